"""Whether a variant is better than the base, judged by its interval."""

from __future__ import annotations

import math
from typing import Literal

from graphnav.ablation.results import Row
from graphnav.stage import Better

Verdict = Literal["base", "better", "worse", "different", "unclear", "unknown"]

WORDS: dict[Verdict, str] = {
    "base": "the base",
    "better": "better than the base",
    "worse": "worse than the base",
    "different": "different from the base",
    "unclear": "no difference that these worlds can tell",
    "unknown": "too few worlds to say",
}


def verdict_of(row: Row, metric: str, better: Better) -> Verdict:
    """Return the verdict of the paired difference: better or worse where it is clear, different where neither is.

    "unknown" where it has no interval: no common worlds with the base, or a single one.
    """
    if row.case.is_base:
        return "base"
    difference = row.differences.get(metric)
    if difference is None or not (math.isfinite(difference.low) and math.isfinite(difference.high)):
        return "unknown"
    if not difference.is_clear:
        return "unclear"
    if better == "neither":
        return "different"
    return "better" if (difference.mean > 0) == (better == "higher") else "worse"
