"""Select fields of a channel's messages by paths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from graphnav.watch.fields.field_columns import check_path
from graphnav.watch.fields.field_path import MISSING, FieldPath


class Selection:
    """The fields of messages selected by paths, all fields without paths.

    The first message determines the type; with paths, messages of other types are skipped.
    """

    def __init__(self, paths: Sequence[FieldPath]) -> None:
        self._paths = paths
        self._lcm_class: type | None = None

    def of(self, lcm_class: type, values: Mapping[str, Any]) -> Mapping[str, Any] | None:
        """Return the selected values of a message, by path; None for a message of another type than the first.

        Missing elements are None. Raises UserError if the first type does not have a field.
        """
        if not self._paths:
            return values
        if self._lcm_class is None:
            for path in self._paths:
                check_path(path, lcm_class)
            self._lcm_class = lcm_class
        if lcm_class is not self._lcm_class:
            return None
        picked = {path.text: path.pick(values) for path in self._paths}
        return {text: None if value is MISSING else value for text, value in picked.items()}
