"""Colours and badges of variants, the same in every chart and on every map."""

from __future__ import annotations

from collections.abc import Sequence

from graphnav.ablation.report.html.markup import Html, esc, tag
from graphnav.ablation.report.html.study_results import StudyResults
from graphnav.ablation.results import Row

BASE = "#1f5fa8"
METHODS = (
    "#d1495b", "#2a9d8f", "#e08e00", "#7b4fa3", "#4f9ddb", "#8c5a2b", "#d36ba6", "#6b8e23", "#00707f", "#b0413e",
)  # fmt: skip
BASELINES = ("#868e99", "#b1b7c0", "#5d6875")
ORACLES = ("#15191f", "#565d68")
OUTCOMES = ("goal", "end", "timeout", "contact", "failed", "stopped")
"""In the order in which bars show them; each has a class in the style sheet."""


def colours_of(study: StudyResults) -> dict[str, str]:
    """Return ``#rrggbb`` for every variant: the base blue, baselines gray, oracles black, methods in turn."""
    roles = {case.variant: case.role for case in study.plan.cases}
    found, used = {study.plan.base: BASE}, {"method": 0, "baseline": 0, "oracle": 0}
    palettes = {"method": METHODS, "baseline": BASELINES, "oracle": ORACLES}
    for variant in dict.fromkeys([*study.own_variants, *study.plan.variants]):
        if variant not in found:
            role = roles[variant]
            found[variant] = palettes[role][used[role] % len(palettes[role])]
            used[role] += 1
    return found


def badge_of(row: Row) -> str:
    """Return the word that stands beside a variant's name; empty for a plain method."""
    return "base" if row.case.is_base else "" if row.case.role == "method" else row.case.role


def badge(word: str) -> Html:
    """Return a word in a box."""
    return tag("span", esc(word), class_=f"pill {word}") if word else ""


def chips(named: Sequence[tuple[str, str]]) -> Html:
    """Return a legend: names, each with its colour."""
    drawn = [tag("span", tag("i", style=f"background:{colour}"), esc(name), class_="chip") for name, colour in named]
    return tag("p", *drawn, class_="chips") if drawn else ""
