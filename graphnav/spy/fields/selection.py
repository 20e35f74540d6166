"""Parts of a channel's messages, as a person names them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from graphnav.spy.fields.field_columns import check_path
from graphnav.spy.fields.field_path import MISSING, FieldPath


class Selection:
    """The fields of messages that some paths name, all where there are no paths.

    The first message decides on the type; with paths, messages of any other type have nothing to be selected.
    """

    def __init__(self, paths: Sequence[FieldPath]) -> None:
        self._paths = paths
        self._lcm_class: type | None = None

    def of(self, lcm_class: type, values: Mapping[str, Any]) -> Mapping[str, Any] | None:
        """Return what the paths name of a message, by path; None for a message of another type than the first.

        An element that a message does not have is None. Raises UserError where the first type has no such field.
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
