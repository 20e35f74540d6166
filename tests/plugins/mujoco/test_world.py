"""`world.mujoco` agrees with `world.pymunk` in what it shows, and drives by its own physics."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from compare_simulators import Both, compared
from graphnav_mujoco import engine
from graphnav_mujoco.world import Mujoco
from graphnav_world.world import Pymunk, WorldOutputs

from graphnav import Finished, Latest, Stamp, State, Twist
from graphnav.arrays import Bytes

pytestmark = pytest.mark.usefixtures("drawn")
EXACT: dict[str, Any] = {"odometry_scale_ratio": 0.0, "odometry_noise_ratio": 0.0, "noise_sigma_gray": 0.0}
BOX = """
start: {at_m: [0, 0], heading_deg: 0}
obstacles:
  - {box: {center_m: [1.5, 0], size_m: [0.4, 0.4], turn_deg: 30}, height_m: 0.3}
  - {circle: {center_m: [0.5, 0.8], radius_m: 0.2}, height_m: 0.3}
"""
CROSSING = """
start: {at_m: [0, 0], heading_deg: 0}
obstacles:
  - circle: {center_m: [1.5, -1], radius_m: 0.2}
    height_m: 0.4
    crosses: {through_m: [[1.5, 1]], speed_mps: 0.5, within_m: 1.2}
"""


@pytest.fixture
def box(tmp_path: Path) -> Path:
    path = tmp_path / "box.yaml"
    path.write_text(BOX)
    return path


def driven(world: Pymunk | Mujoco, twist: Twist, ticks: int, seed: int = 1) -> Iterator[WorldOutputs]:
    """Yield the outputs of a drive by one command, until it ends."""
    world.reset(seed)
    for k in range(ticks):
        try:
            yield world.step(Latest(twist, 0.0), Stamp(100_000 * k))
        except Finished as ending:
            yield ending.outputs
            break
    world.close()


def obstacle_of(outputs: WorldOutputs) -> Bytes:
    """Return the mask of the truth."""
    assert outputs.truth is not None
    return outputs.truth.obstacle


@pytest.mark.parametrize(("name", "seed", "tilt_deg"), [("corridor_ccw", 7, 75.0), ("movers", 1, 60.0)])
def test_both_simulators_show_the_same(name: str, seed: int, tilt_deg: float, maps: Path) -> None:
    both = Both(maps / f"{name}.yaml", seed, tilt_deg=tilt_deg)
    for found in compared(both, 5):
        assert found.iou > 0.998, "only pixels that an edge crosses within their rounding may differ"
        assert found.depth_m < 1e-3, "the depth buffer has 24 bits between 2 cm and 400 m, 20 um at 3 m"
        assert found.flow_px < 0.01
        assert found.gray < 3.0, "mip levels are filtered in another way"
    both.close()


def test_it_draws_where_mujoco_was_imported_before(maps: Path) -> None:
    drawing = f"""
import mujoco
from graphnav import Latest, Stamp, Twist
from graphnav_mujoco.world import Mujoco
world = Mujoco(map={str(maps / "empty.yaml")!r})
world.check()
world.reset(1)
print(world.step(Latest(Twist(0.0, 0.0), 0.0), Stamp(0)).image.pixels.std() > 1)
world.close()
"""
    environment = {key: value for key, value in os.environ.items() if key != engine.CHOSEN_BY}
    done = subprocess.run([sys.executable, "-c", drawing], env=environment, capture_output=True, text=True, check=False)
    assert done.stdout == "True\n", done.stderr


def test_the_image_is_neither_mirrored_nor_turned(box: Path) -> None:
    world = Mujoco(map=box, truth=True, tilt_deg=45.0, **EXACT)
    *_, outputs = driven(world, Twist(v_mps=0.0, omega_radps=0.0), 2)
    obstacle = obstacle_of(outputs)
    rows, cols = np.nonzero(obstacle)
    of_pillar = cols < 60
    assert of_pillar.any(), "the pillar stands to the left"
    assert (cols[~of_pillar] >= 60).any()
    assert not obstacle[:, 110:].any()
    assert rows[~of_pillar].max() < 110, "the floor at the robot's foot is free"


def test_the_same_seed_has_the_same_bytes(maps: Path) -> None:
    drives = [
        [one.image.pixels.tobytes() for one in driven(Mujoco(map=maps / "movers.yaml"), Twist(0.3, 0.4), 8, seed)]
        for seed in (1, 1, 2)
    ]
    assert drives[0] == drives[1]
    assert drives[0] != drives[2]


@pytest.mark.parametrize(("v_mps", "omega_radps"), [(0.4, 0.0), (0.3, 0.5), (0.0, 1.0), (-0.3, 0.0)])
def test_it_follows_the_command_and_slides_a_little(v_mps: float, omega_radps: float, maps: Path) -> None:
    ends: list[State] = []
    turned: list[float] = []
    for cls in (Pymunk, Mujoco):
        outputs = list(driven(cls(map=maps / "empty.yaml", **EXACT), Twist(v_mps, omega_radps), 21))
        ends.append(outputs[-1].state)
        turned.append(sum(one.motion.turn_rad for one in outputs if one.motion is not None))
    (x, y), (other_x, other_y) = ((state.x_m, state.y_m) for state in ends)
    away = math.hypot(x - other_x, y - other_y)
    assert 0.0 < away < 0.03, "the motors follow with 20 ms, and tyres creep"
    assert ends[1].v_mps == pytest.approx(v_mps, abs=0.01)
    assert ends[1].omega_radps == pytest.approx(omega_radps, abs=0.02)
    assert turned[1] == pytest.approx(turned[0], abs=0.04)


def test_a_slip_is_not_seen_by_the_wheels(maps: Path) -> None:
    outputs = list(driven(Mujoco(map=maps / "empty.yaml", slip_ratio=0.2, **EXACT), Twist(0.4, 0.0), 21))
    start, end = outputs[0].state, outputs[-1].state
    way_m = math.hypot(end.x_m - start.x_m, end.y_m - start.y_m)
    measured_m = sum(one.motion.forward_m for one in outputs if one.motion is not None)
    assert measured_m == pytest.approx(0.4 * (2.0 - 0.1), abs=0.02)
    assert way_m < 0.97 * measured_m


@pytest.mark.parametrize("size_m", [None, (0.5, 0.3)])
def test_a_contact_ends_the_drive_where_it_does_in_the_other(size_m: tuple[float, float] | None, box: Path) -> None:
    both = [list(driven(cls(map=box, robot_size_m=size_m, **EXACT), Twist(0.4, 0.0), 60)) for cls in (Pymunk, Mujoco)]
    ends = [outputs[-1].state for outputs in both]
    assert [end.contact for end in ends] == [True, True]
    assert ends[1].x_m == pytest.approx(ends[0].x_m, abs=0.01), "the end is where the rim touches"
    assert ends[1].clearance_m == 0.0
    for ours, other in zip(*both, strict=False):
        assert other.state.clearance_m == pytest.approx(ours.state.clearance_m, abs=0.02)


def test_who_crosses_sets_out_when_the_robot_comes(tmp_path: Path) -> None:
    path = tmp_path / "crossing.yaml"
    path.write_text(CROSSING)
    outputs = list(driven(Mujoco(map=path, truth=True, **EXACT), Twist(0.4, 0.0), 30))
    ways = np.array([one.state.moving[0, 1] for one in outputs])
    assert ways[0] == -1.0
    assert ways[-1] > -0.9, "it has set out"
    assert any(obstacle_of(one).any() for one in outputs[1:]), "the body is drawn where it is"


def test_a_photograph_covers_the_floor_without_a_seam(maps: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    slope = np.tile(np.linspace(60, 180, 64), (64, 1)).astype(np.uint8)
    photographs = types.SimpleNamespace(gravel=lambda: slope)
    monkeypatch.setitem(sys.modules, "skimage.data", photographs)
    world = Mujoco(map=maps / "empty.yaml", floor="gravel", photo_m=0.5, tilt_deg=90.0, **EXACT)
    world.check()
    (first,) = driven(world, Twist(v_mps=0.0, omega_radps=0.0), 1)
    pixels = first.image.pixels.astype(int)
    steps = np.maximum(np.abs(np.diff(pixels, axis=0)).max(), np.abs(np.diff(pixels, axis=1)).max())
    assert pixels.min() < 80
    assert pixels.max() > 160
    assert steps < 10, "the photograph goes on as its mirror image"


@pytest.mark.parametrize("lights", [{"lamp_ratio": 0.5}, {"glare_ratio": 1.0}, {"tilt_deg": 50.0, "shadow_ratio": 0.6}])
def test_light_differs_from_pixel_to_pixel(lights: dict[str, Any], box: Path) -> None:
    still = Twist(v_mps=0.0, omega_radps=0.0)
    plain, lit = (
        first.image.pixels.astype(float)
        for given in ({"tilt_deg": lights.get("tilt_deg", 75.0)}, lights)
        for first in driven(Mujoco(map=box, **EXACT, **given), still, 1)
    )
    ratio = lit / np.maximum(plain, 20.0)
    assert ratio.max() - ratio.min() > 0.3
    assert lit.mean() == pytest.approx(plain.mean(), rel=0.4)


def bytes_of(world: Pymunk | Mujoco) -> list[bytes]:
    """Return what a short drive shows and tells of itself."""
    return [
        one.image.pixels.tobytes() + repr((one.state.x_m, one.state.y_m, one.motion)).encode()
        for one in driven(world, Twist(0.3, 0.4), 8)
    ]


def test_pictures_and_physics_of_the_other_simulator_are_its_own(maps: Path) -> None:
    where = maps / "movers.yaml"
    ours = bytes_of(Pymunk(map=where))
    assert bytes_of(Mujoco(map=where, pictures="pymunk", physics="pymunk")) == ours
    drawn, moved = (
        list(driven(world, Twist(0.3, 0.4), 8))
        for world in (
            Mujoco(map=where, truth=True, physics="pymunk", **EXACT),
            Mujoco(map=where, truth=True, pictures="pymunk", **EXACT),
        )
    )
    plain, all_mujoco = (
        list(driven(cls(map=where, truth=True, **EXACT), Twist(0.3, 0.4), 8)) for cls in (Pymunk, Mujoco)
    )
    for mine, other in ((drawn, plain), (moved, all_mujoco)):
        assert [(one.state.x_m, one.state.y_m) for one in mine] == [(one.state.x_m, one.state.y_m) for one in other]
        apart = np.abs(mine[-1].image.pixels.astype(float) - other[-1].image.pixels).mean()
        assert 0.0 < apart < 3.0, "the same scene, drawn by another engine"
        assert np.mean(obstacle_of(mine[-1]) != obstacle_of(other[-1])) < 0.002
