"""Intervals and tests of paired differences."""

from graphnav.studies.ablation.results.statistics.e_process import anytime_p
from graphnav.studies.ablation.results.statistics.hypothesis_tests import (
    ALPHA,
    EXACT_BELOW,
    Significance,
    holm,
    min_worlds,
    p_value,
)
from graphnav.studies.ablation.results.statistics.intervals import (
    bonett_price,
    difference_interval,
    mean_interval,
    student,
    wilson,
)

__all__ = [
    "ALPHA",
    "EXACT_BELOW",
    "Significance",
    "anytime_p",
    "bonett_price",
    "difference_interval",
    "holm",
    "mean_interval",
    "min_worlds",
    "p_value",
    "student",
    "wilson",
]
