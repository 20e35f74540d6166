"""The forward-backward check finds the vectors that the reversed pair contradicts."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from graphnav_flow.lucas_kanade import Consistency, LucasKanade

if TYPE_CHECKING:
    from tests.plugins.flow.conftest import Pair


def field(u: float, v: float) -> np.ndarray:
    return np.full((20, 30, 2), (u, v), np.float32)


def test_opposite_flows_agree() -> None:
    off_px = Consistency(20, 30).disagreement_px(field(2.5, -1.0), field(-2.5, 1.0))
    assert np.abs(off_px[:18, 4:]).max() < 1e-6


def test_the_disagreement_is_the_length_of_the_sum() -> None:
    off_px = Consistency(20, 30).disagreement_px(field(2.0, 0.0), field(1.0, 4.0))
    assert np.abs(off_px[:, 4:] - 5.0).max() < 1e-6


def test_the_reversed_flow_is_read_where_the_vector_comes_from() -> None:
    backward = field(0.0, 0.0)
    backward[:, 10] = (-3.0, 0.0)
    off_px = Consistency(20, 30).disagreement_px(field(3.0, 0.0), backward)
    assert np.flatnonzero(off_px[5] < 1).tolist() == [13]


def test_vectors_from_outside_disagree() -> None:
    off_px = Consistency(20, 30).disagreement_px(field(5.0, 0.0), field(-5.0, 0.0))
    assert off_px[:, :4].min() > 1000
    assert np.abs(off_px[:, 5:]).max() < 1e-6


def test_the_check_only_clears_validity(warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (x + 1.3, y))
    usual, checked = pair.estimate(LucasKanade()), pair.estimate(LucasKanade(max_disagreement_px=1.0))
    assert np.array_equal(usual.uv_px, checked.uv_px)
    assert not np.any(checked.valid > usual.valid)
    assert checked.valid.mean() > 0.95 * usual.valid.mean()


def test_what_has_another_scene_behind_it_is_not_valid(warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (x + 1.3, y))
    now = pair.now.copy()
    now[40:80, 60:120] = warped_pair(lambda x, y: (x, y), seed=9).now[40:80, 60:120]
    changed = type(pair)(pair.before, now, pair.flow_px, pair.inside)
    flow = changed.estimate(LucasKanade(max_disagreement_px=1.0))
    assert flow.valid[50:70, 70:110].mean() < 0.5 * flow.valid[50:70, 10:50].mean()
