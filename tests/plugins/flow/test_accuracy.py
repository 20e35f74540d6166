"""Estimated flow agrees with the analytic truth of warped patterns."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_flow.dis import Dis
from graphnav_flow.farneback import Farneback
from graphnav_flow.lucas_kanade import LucasKanade

from graphnav import Stage
from graphnav.arrays import Doubles

if TYPE_CHECKING:
    from tests.plugins.flow.conftest import Pair

CENTRE = (79.5, 59.5)
ESTIMATORS = [LucasKanade, Farneback, Dis]


def error_of_valid_px(pair: Pair, stage: Stage) -> float:
    flow = pair.estimate(stage)
    valid = flow.valid > 0
    assert valid.mean() > 0.5
    return float(pair.error_px(flow)[valid].mean())


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_what_moves_right_and_down_flows_with_positive_signs(
    estimator: type[Stage], warped_pair: Callable[..., Pair]
) -> None:
    flow = warped_pair(lambda x, y: (x - 2.0, y - 1.0)).estimate(estimator())
    u, v = flow.uv_px[flow.valid > 0].mean(axis=0)
    assert u == pytest.approx(2.0, abs=0.1)
    assert v == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.25, 0.0), (0.5, -0.5), (1.37, -0.61), (-3.0, 2.0), (11.3, -7.2)])
def test_a_shift_is_found_to_a_fiftieth_of_a_pixel(
    shift: tuple[float, float], warped_pair: Callable[..., Pair]
) -> None:
    assert error_of_valid_px(warped_pair(lambda x, y: (x + shift[0], y + shift[1])), LucasKanade()) < 0.02


@pytest.mark.parametrize("shift", np.linspace(0.0, 1.0, 9))
def test_no_fraction_of_a_pixel_is_favoured(shift: float, warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (x + shift, y), noise=0.0)
    flow = pair.estimate(LucasKanade())
    bias = (flow.uv_px - pair.flow_px)[flow.valid > 0].mean(axis=0)
    assert np.abs(bias).max() < 0.005


@pytest.mark.parametrize("turn_rad", [0.02, 0.05, -0.15])
def test_a_rotation_is_followed(turn_rad: float, warped_pair: Callable[..., Pair]) -> None:
    def came_from(x: Doubles, y: Doubles) -> tuple[Doubles, Doubles]:
        dx, dy = x - CENTRE[0], y - CENTRE[1]
        c, s = math.cos(turn_rad), math.sin(turn_rad)
        return CENTRE[0] + c * dx - s * dy, CENTRE[1] + s * dx + c * dy

    assert error_of_valid_px(warped_pair(came_from), LucasKanade()) < 0.05


@pytest.mark.parametrize("zoom", [0.95, 1.05])
def test_a_zoom_is_followed(zoom: float, warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (CENTRE[0] + zoom * (x - CENTRE[0]), CENTRE[1] + zoom * (y - CENTRE[1])))
    assert error_of_valid_px(pair, LucasKanade()) < 0.05


def test_more_layers_follow_larger_displacements(warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (x + 14.0, y))
    few, usual = (pair.estimate(LucasKanade(layers=layers)) for layers in (0, 3))
    assert pair.error_px(few)[pair.inside].mean() > 1.0
    assert few.valid.mean() < 0.05, "what cannot be followed is not valid"
    assert pair.error_px(usual)[usual.valid > 0].mean() < 0.05


@pytest.mark.parametrize("turn_radps", [0.0, 0.5, 1.0, 1.5])
def test_it_errs_at_most_085_of_farneback_on_a_drive(
    turn_radps: float, driven_pairs: Callable[..., list[Pair]]
) -> None:
    pairs = driven_pairs(turn_radps, 8)
    ours, theirs = (
        np.mean([pair.error_px(pair.estimate(stage)).mean() for pair in pairs])
        for stage in (LucasKanade(), Farneback())
    )
    assert ours <= 0.85 * theirs


def test_the_smoothed_flow_keeps_the_edges_of_a_moving_box(warped_pair: Callable[..., Pair]) -> None:
    still = warped_pair(lambda x, y: (x, y), seed=1)
    moved = warped_pair(lambda x, y: (x - 3.0, y), seed=2)
    box = np.s_[40:80, 60:100]
    before, now = still.before.copy(), still.now.copy()
    before[40:80, 57:97], now[box] = moved.before[40:80, 57:97], moved.now[box]
    flow = type(still)(before, now, still.flow_px, still.inside).estimate(LucasKanade())
    assert flow.uv_px[48:72, 68:92, 0].min() > 2.5
    outside = np.ones((120, 160), bool)
    outside[28:92, 45:112] = False
    assert np.abs(flow.uv_px[outside & (flow.valid > 0)]).max() < 0.2
