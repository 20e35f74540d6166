"""Values of a study as tables show them, numbers as they were written."""

from __future__ import annotations

import re

from graphnav.core.spec import Value, parse_scalar, write_value

_NUMBER = re.compile(r"[^\s,\[\]{}#]+")


class SourceText:
    """The text of a file, to look up how its values were written."""

    def __init__(self, data: bytes) -> None:
        self._lines = data.decode("utf-8-sig", "replace").splitlines()

    def label(self, value: Value) -> str:
        """Return a value as tables show it: 0.50 stays 0.50, strings have no quotes."""
        return value.data if isinstance(value.data, str) and value.data.isprintable() else self._item(value)

    def _item(self, value: Value) -> str:
        if isinstance(value.data, list):
            return "[" + ", ".join(map(self._item, value.data)) + "]"
        if isinstance(value.data, int | float) and not isinstance(value.data, bool):
            line = self._lines[value.place.line - 1][value.place.column - 1 :]
            token = _NUMBER.match(line)
            if token and repr(parse_scalar(token[0])) == repr(value.data):
                return token[0]
        return write_value(value.plain())
