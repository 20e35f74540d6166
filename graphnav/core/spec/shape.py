"""Check the shape of a graph's values, and collect the problems."""

from __future__ import annotations

import math
from collections.abc import Callable

from graphnav.core.errors import Hint, Place, Problem, did_you_mean
from graphnav.core.spec.value import Entry, Value


class Shapes:
    """Takes values apart; what has another shape than it should is added to ``problems``."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []

    def _section(self, words: dict[str, Entry], key: str, who: str = "") -> dict[str, Entry]:
        return self._mapping(words[key].value, who or f"'{key}'") if key in words else {}

    def _mapping(self, value: Value, who: str) -> dict[str, Entry]:
        if isinstance(value.data, dict):
            return dict(value.data)
        if value.data is not None:
            self._problem(value.place, f"{who} must be a mapping, not {value.kind}")
        return {}

    def _text(self, value: Value, who: str, hint: str = "put it in quotes if it is meant") -> str:
        if isinstance(value.data, str):
            return value.data
        self._problem(value.place, f"{who} must be a string, not {value.kind}", hint)
        return ""

    def _number(self, value: Value, who: str, wanted: str, fits: Callable[[float], bool]) -> float | None:
        """Return a finite number that ``fits``, None for anything else, which is a problem."""
        number = value.data
        if isinstance(number, int | float) and not isinstance(number, bool) and fits(number) and math.isfinite(number):
            return number
        self._problem(value.place, f"{who} must be {wanted}, not {value.kind}")
        return None

    def _known(self, words: dict[str, Entry], keys: tuple[str, ...], who: str) -> bool:
        for word, entry in words.items():
            if word not in keys:
                hint = did_you_mean(word, keys) or f"keys are {', '.join(keys)}"
                self._problem(entry.place, f"{who} has no key '{word}'", hint)
        return all(word in keys for word in words)

    def _problem(self, place: Place, what: str, hint: Hint = "") -> None:
        self.problems.append(Problem(place, what, hint))
