"""Colours and badges of variants, the same in every chart and on every map."""

from __future__ import annotations

from graphnav.studies.ablation.plan import Case
from graphnav.studies.ablation.report.html.study_results import StudyResults

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


def badge_of(case: Case) -> str:
    """Return the label beside a variant's name; empty for a method that is not the base."""
    return "base" if case.is_base else "" if case.role == "method" else case.role
