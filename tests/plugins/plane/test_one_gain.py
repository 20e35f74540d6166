"""The one gain is the true one, whatever the odometry errs by and while obstacles are less than half."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_plane.ica import Ica
from graphnav_plane.one_gain import OneGain, robust_gain
from graphnav_plane.residual import Residual

from graphnav import Plane, Stamp

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scenes


@pytest.mark.parametrize("gain", [0.0, 0.75, 1.0, 1.25, -1.0])
def test_the_gain_of_flow_without_noise_is_exact(scenes: Scenes, gain: float) -> None:
    planar_px = scenes.floor(3.0, 0.05).reshape(-1, 2)
    assert robust_gain(gain * planar_px, planar_px, 0.1) == pytest.approx(gain, abs=1e-9)


@pytest.mark.parametrize("share", [0.1, 0.3, 0.45])
def test_obstacles_do_not_pull_the_gain(scenes: Scenes, share: float) -> None:
    scene = scenes.scene(share, gain=0.8, noise_px=0.03)
    flow_px, planar_px = (
        vectors.reshape(-1, 2).astype(float) for vectors in (scene.flow.uv_px, scene.planar.planar_uv_px)
    )
    of_all = float((flow_px * planar_px).sum() / (planar_px**2).sum())
    gain = robust_gain(flow_px, planar_px, 0.1)
    assert gain == pytest.approx(0.8, abs=0.003)
    assert abs(gain - 0.8) < abs(of_all - 0.8) / 3


def test_a_robot_at_rest_has_no_gain() -> None:
    zero = np.zeros((20, 2))
    assert robust_gain(zero, zero, 0.1) == 0.0


@pytest.mark.parametrize("gain", [0.75, 1.25])
def test_where_the_planar_flow_errs_by_a_gain_it_sees_what_ica_sees_and_the_residual_does_not(
    scenes: Scenes, gain: float
) -> None:
    scene = scenes.scene(0.3, gain=gain)
    found = {}
    for detector in (OneGain(), Ica(), Residual(rule="fixed")):
        detector.reset(0)
        made = detector.step(scene.flow, scene.planar, Stamp(0))
        found[type(detector)] = (made if isinstance(made, Plane) else made.plane).obstacle > 0
    right = {kind: float((mask == scene.obstacle).mean()) for kind, mask in found.items()}
    assert right[OneGain] > 0.95
    assert right[OneGain] == pytest.approx(right[Ica], abs=0.02)
    assert right[Residual] < 0.6
