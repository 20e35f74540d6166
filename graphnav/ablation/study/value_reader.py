"""Read strings and ``--set`` texts of a study file, with their places."""

from __future__ import annotations

from graphnav.ablation.study.source_text import SourceText
from graphnav.errors import Place, Problem
from graphnav.spec import Value

Texts = dict[str, Place]
"""Strings, each with its place."""


class ValueReader:
    """Reads the words of one file; what is wrong is added to ``problems``."""

    def __init__(self, source: SourceText, problems: list[Problem]) -> None:
        self.source = source
        self.problems = problems

    def problem(self, place: Place, what: str, hint: str = "") -> None:
        """Add something that is wrong."""
        self.problems.append(Problem(place, what, hint))

    def texts(self, value: Value, who: str, example: str) -> Texts:
        """Return the texts of a list, or the one text."""
        items = value.data if isinstance(value.data, list) else [value]
        found: Texts = {}
        for item in items:
            if not isinstance(item.data, str):
                self.problem(
                    item.place, f"{who} must be a list of texts, but this is {item.kind}", f"write [{example}]"
                )
            elif item.data in found:
                self.problem(item.place, f"'{item.data}' stands here twice", "keep one")
            else:
                found[item.data] = item.place
        if not items:
            self.problem(value.place, f"{who} is an empty list", f"write [{example}], or leave the key out")
        return found

    def sets(self, value: Value, who: str) -> Texts:
        """Return ``--set`` texts of a list of them, or of a mapping of targets to values."""
        if not isinstance(value.data, dict):
            return self.texts(value, who, "run.until_s=60")
        found: Texts = {}
        for target, entry in value.data.items():
            given = entry.value
            if isinstance(given.data, dict):
                self.problem(given.place, f"the value of '{target}' is a mapping", "write stage.parameter: value")
            found[f"{target}={self.source.text(given)}"] = given.place
        return found
