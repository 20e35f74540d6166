"""Hand over what a study sets: ``--set`` texts, each with its place.

This is the one place where values of a study become texts.
"""

from __future__ import annotations

from collections.abc import Mapping

from graphnav.ablation.study.source_text import SourceText
from graphnav.errors import Place, Problem
from graphnav.spec import Value

Texts = dict[str, Place]
"""Strings, each with its place."""


def set_texts(settings: Mapping[str, Value], source: SourceText, problems: list[Problem]) -> Texts:
    """Return the ``--set`` texts of targets and their values; what is wrong is added to ``problems``."""
    found: Texts = {}
    for target, value in settings.items():
        if isinstance(value.data, dict):
            what = f"the value of '{target}' is a mapping"
            problems.append(Problem(value.place, what, "write stage.parameter: value"))
        found[f"{target}={source.text(value)}"] = value.place
    return found
