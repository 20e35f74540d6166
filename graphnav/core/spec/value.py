"""The values of a YAML file, each with its place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from graphnav.core.errors import Place
from graphnav.core.spec.scalar import Scalar


@dataclass(frozen=True)
class Value:
    """A scalar, a list of values, or a mapping of strings to entries."""

    data: Scalar | list[Value] | dict[str, Entry]
    place: Place

    def plain(self) -> Any:
        """Return the value without places."""
        if isinstance(self.data, list):
            return [item.plain() for item in self.data]
        if isinstance(self.data, dict):
            return {key: entry.value.plain() for key, entry in self.data.items()}
        return self.data

    @property
    def kind(self) -> str:
        """Description of the value for error messages: ``a list``, ``the number 3``."""
        match self.data:
            case dict():
                return "a mapping"
            case list():
                return "a list"
            case None:
                return "empty"
            case bool():
                return "true" if self.data else "false"
            case str():
                return (
                    f"the string '{self.data}'" if len(self.data) <= 60 else f"a string of {len(self.data)} characters"
                )
            case _:
                return f"the number {self.data}"


@dataclass(frozen=True)
class Entry:
    """The value of a key, and the place of the key."""

    place: Place
    value: Value
    is_override: bool = False
    """Whether an override gives it, not the graph's own file."""
