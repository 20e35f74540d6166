"""Where obstacle begins, by each rule."""

from __future__ import annotations

import numpy as np
import pytest
from graphnav_plane.detector import threshold
from graphnav_plane.ica import Ica

from graphnav import ParamError


def test_mad_is_a_multiple_of_the_median() -> None:
    assert threshold("mad", np.array([0.0, 1.0, 2.0, 3.0, 100.0]), 4.0, 0.1) == 8.0


def test_fixed_does_not_look_at_the_scores() -> None:
    assert threshold("fixed", np.array([5.0, 6.0]), 4.0, 0.3) == 0.3


def test_otsu_splits_two_heaps_between_them() -> None:
    rng = np.random.default_rng(0)
    scores = np.concatenate([rng.uniform(0.0, 0.2, 900), rng.uniform(1.0, 1.4, 300)])
    assert 0.2 <= threshold("otsu", scores, 4.0, 0.1) <= 1.0


@pytest.mark.parametrize("rule", ["mad", "otsu", "fixed"])
@pytest.mark.parametrize("scores", [np.zeros(50), np.full(50, 0.01), np.zeros(0), np.linspace(0, 0.05, 50)])
def test_no_rule_splits_noise(rule: str, scores: np.ndarray) -> None:
    assert threshold(rule, scores, 4.0, 0.2) == 0.2  # type: ignore[arg-type]


def test_an_unknown_rule_is_refused() -> None:
    with pytest.raises(ParamError, match="must be"):
        Ica(rule="mean")  # type: ignore[arg-type]
