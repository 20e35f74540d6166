"""Whether a variant is better than the base by the metric that decides."""

from __future__ import annotations

import math
from typing import Literal

from graphnav.core.stage import Better
from graphnav.studies.ablation.results import Row

Verdict = Literal["base", "better", "worse", "different", "small", "unclear", "unknown", "untested"]

WORDS: dict[Verdict, str] = {
    "base": "the base",
    "better": "better than the base",
    "worse": "worse than the base",
    "different": "different from the base",
    "small": "a difference smaller than what matters",
    "unclear": "no difference that these worlds can tell",
    "unknown": "too few worlds to say",
    "untested": "not tested",
}


def verdict_of(row: Row, metric: str, better: Better) -> Verdict:
    """Return the verdict of the paired difference: better or worse where it is clear, different where neither is.

    "untested" of a metric that does not decide, or that depends on the frames that a drive meets; "small" where the
    difference is significant and does not matter; "unknown" where it has no interval, or so few worlds that none of the
    table's variants could be told apart.
    """
    if row.case.is_base:
        return "base"
    if metric in row.own_frames:
        return "untested"
    difference = row.differences.get(metric)
    if difference is None or not (math.isfinite(difference.low) and math.isfinite(difference.high)):
        return "unknown"
    if difference.significance is None:
        return "untested"
    if difference.n < difference.significance.min_worlds:
        return "unknown"
    if not difference.is_clear:
        return "small" if difference.is_significant and not difference.matters else "unclear"
    if better == "neither":
        return "different"
    return "better" if (difference.mean > 0) == (better == "higher") else "worse"
