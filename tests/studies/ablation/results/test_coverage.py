"""How often intervals and tests reject a true null: `accept.py coverage` in short."""

from __future__ import annotations

import pytest
from acceptance.coverage import MEANS, NULLS, Null, covered, rejected

STUDIES = 2000
SCATTER = 3 * (0.05 * 0.95 / STUDIES) ** 0.5
"""Three standard errors of a share of 5 % of the studies."""


@pytest.mark.parametrize("n_worlds", [6, 20])
@pytest.mark.parametrize("null", NULLS, ids=lambda null: null.name)
def test_true_nulls_are_rejected_as_rarely_as_promised(null: Null, n_worlds: int) -> None:
    by_interval, by_test = rejected(null, n_worlds, STUDIES, (7, n_worlds))
    assert null.min_rejected - SCATTER <= by_interval <= null.max_rejected + SCATTER
    assert by_test <= 0.05 + SCATTER


def test_intervals_of_single_skewed_means_are_short() -> None:
    draw, mean = MEANS["lognormal"]
    assert covered(draw, mean, 6, STUDIES, (7, 6)) < 0.9, "so they are marked approximate"
    draw, mean = MEANS["normal"]
    assert covered(draw, mean, 6, STUDIES, (7, 6)) == pytest.approx(0.95, abs=SCATTER)
