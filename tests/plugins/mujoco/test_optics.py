"""`world.mujoco` has the optics of `world.pymunk`, on its own pictures and its own truth."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_mujoco.base import planar_base, positions
from graphnav_mujoco.eye import eye_of
from graphnav_mujoco.world import Mujoco
from graphnav_world.world import Pymunk

from tests.plugins.world.optics import last, lean_errors_px, standing_pictures, undistorted, unprepared_gray

pytestmark = pytest.mark.usefixtures("drawn")


@pytest.mark.parametrize(
    "optics",
    [
        {"distortion": (0.15, 0.02)},
        {"distortion": (-0.2, 0.04), "camera_roll_deg": -8.0},
        {"defocus_px": 3.0},
        {"jpeg_quality": 60},
        {"light_ratio": 0.3, "auto_exposure_s": 0.5},
    ],
)
def test_both_simulators_have_the_same_optics(optics: dict[str, Any], maps: Path) -> None:
    ours, other = (last(make, maps / "pillars.yaml", tilt_deg=45.0, **optics) for make in (Pymunk, Mujoco))
    assert ours.truth is not None
    assert other.truth is not None
    mask, other_mask = (one.obstacle.astype(bool) for one in (ours.truth, other.truth))
    assert mask.any()
    assert (mask & other_mask).sum() / (mask | other_mask).sum() > 0.98
    same = mask == other_mask
    depth_error_m = np.abs(ours.truth.depth_m - other.truth.depth_m)[same]
    assert np.median(depth_error_m) < 1e-4
    assert np.quantile(depth_error_m, 0.99) < 0.01, "the faces of a pillar are one surface to MuJoCo, many to pymunk"
    assert np.abs(ours.truth.flow_px - other.truth.flow_px)[same].max() < 0.05, "it settles a little"
    assert np.abs(ours.image.pixels.astype(float) - other.image.pixels).mean() < 5.0, (
        "mip levels are filtered in another way"
    )
    plain = last(Mujoco, maps / "pillars.yaml", tilt_deg=45.0, light_ratio=optics.get("light_ratio", 1.0))
    assert np.abs(plain.image.pixels.astype(float) - other.image.pixels).mean() > 3.0, "they change the picture"


@pytest.mark.parametrize("rows", [range(7), range(41, 60), range(119, 120)])
def test_rows_are_those_of_the_picture(rows: range, maps: Path) -> None:
    world = Mujoco(map=maps / "movers.yaml", tilt_deg=50.0)
    world.reset(3)
    x, y, yaw = world._draw.start
    then, now = (
        eye_of(world._camera, *planar_base(x + 0.03 * k, y, yaw), positions(world._base.movers, 0.1 * k))
        for k in (0, 1)
    )
    complete, part = (world._render(now, then, [], one) for one in (None, rows))
    world.close()
    cut = slice(rows.start, rows.stop)
    assert np.abs(part.gray - complete.gray[cut]).mean() < 0.5, "OpenGL rounds by the place in the viewport"
    same = part.surface == complete.surface[cut]
    assert same.mean() > 0.99
    np.testing.assert_allclose(part.depth_m[same], complete.depth_m[cut][same], rtol=1e-4)
    assert part.flow_px is not None
    assert complete.flow_px is not None
    np.testing.assert_allclose(part.flow_px[same], complete.flow_px[cut][same], atol=0.01)


def test_an_upright_edge_leans_in_a_turn(tmp_path: Path) -> None:
    assert np.abs(lean_errors_px(Mujoco, tmp_path)).max() <= 1.0


def test_a_robot_that_stands_sees_the_same_through_a_rolling_shutter(maps: Path) -> None:
    one, other = standing_pictures(Mujoco, maps / "pillars.yaml", shutter_s=0.06)
    assert one == other


def test_prepare_undistorts_the_picture(maps: Path, tmp_path: Path) -> None:
    as_it_is, prepared = unprepared_gray(undistorted(Mujoco, maps / "pillars.yaml", tmp_path, (-0.3, 0.09)))
    assert as_it_is > 5.0
    assert prepared < 1.0
