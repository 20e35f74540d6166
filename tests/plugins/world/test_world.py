"""The world as a stage: what it publishes, when it ends, what its seed decides."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from graphnav_world.world import Pymunk, WorldOutputs

from graphnav import Finished, Latest, ParamError, Stamp, Twist, UserError
from graphnav.core.codec import encode
from graphnav.core.graph.find import shipped_folder
from graphnav.core.stage import tell_readers

TICK_US = 100_000


def drive(world: Pymunk, twist: Twist | None, ticks: int, seed: int = 3) -> tuple[list[WorldOutputs], str]:
    """Return what the world published and how it ended."""
    world.reset(seed)
    outputs: list[WorldOutputs] = []
    for k in range(ticks):
        try:
            outputs.append(world.step(Latest(twist, 0.1), Stamp(k * TICK_US)))
        except Finished as end:
            return [*outputs, end.outputs], end.outcome
    return outputs, "timeout"


def test_the_first_tick_has_the_map_but_neither_motion_nor_truth(maps: Path) -> None:
    (first, second), _ = drive(Pymunk(map=maps / "corridor_ccw.yaml"), None, 2)
    assert (first.motion, first.truth) == (None, None)
    assert first.map is not None
    assert first.goal is not None
    assert second.map is None
    assert second.motion is not None
    assert second.truth is not None
    assert second.truth.interval_us == second.motion.interval_us == TICK_US
    assert np.abs(second.truth.flow_px).max() < 1e-4, "a robot without a command stands"


def test_outputs_have_the_promised_shapes(maps: Path) -> None:
    outputs, _ = drive(Pymunk(map=maps / "crossing.yaml", size=(64, 48)), Twist(v_mps=0.3, omega_radps=0.1), 3)
    last = outputs[-1]
    assert last.image.pixels.shape == (48, 64)
    assert last.image.pixels.dtype == np.uint8
    assert last.truth is not None
    assert (last.truth.obstacle.dtype, last.truth.obstacle.shape) == (np.dtype(np.uint8), (48, 64))
    assert (last.truth.depth_m.dtype, last.truth.depth_m.shape) == (np.dtype(np.float32), (48, 64))
    assert (last.truth.flow_px.dtype, last.truth.flow_px.shape) == (np.dtype(np.float32), (48, 64, 2))
    assert last.state.moving.shape == (2, 3)
    about = outputs[0].map
    assert about is not None
    assert about.vertices_m.shape == (len(about.body), 2)
    assert (np.diff(about.body) >= 0).all()
    assert sorted(set(about.kind.tolist())) == [0, 1, 2]
    assert len(about.height_m) == len(about.kind) == about.body.max() + 1


@pytest.mark.parametrize(
    ("truth", "ports", "shown"), [(None, (), 0), (None, ("truth",), 2), (True, (), 2), (False, ("truth",), 0)]
)
def test_truth_is_published_where_it_is_read_and_changes_nothing_else(
    truth: bool | None, ports: tuple[str, ...], shown: int, maps: Path
) -> None:
    full, _ = drive(Pymunk(map=maps / "crossing.yaml"), Twist(v_mps=0.3, omega_radps=0.1), 3)
    world = Pymunk(map=maps / "crossing.yaml", truth=truth)
    tell_readers(world, ports)
    outputs, _ = drive(world, Twist(v_mps=0.3, omega_radps=0.1), 3)
    assert sum(out.truth is not None for out in outputs) == shown
    for one, other in zip(outputs, full, strict=True):
        for port in ("image", "motion", "state", "goal", "map"):
            ours, theirs = getattr(one, port), getattr(other, port)
            assert (ours is None) == (theirs is None)
            assert ours is None or encode(ours, 0, 0) == encode(theirs, 0, 0)


def test_truth_belongs_to_the_motion_between_the_frames(maps: Path) -> None:
    world = Pymunk(map=maps / "empty.yaml", odometry_scale_ratio=0.0, odometry_noise_ratio=0.0)
    outputs, _ = drive(world, Twist(v_mps=0.3, omega_radps=0.5), 12)
    then, now = outputs[-2].state, outputs[-1].state
    motion, truth = outputs[-1].motion, outputs[-1].truth
    assert motion is not None
    assert truth is not None
    assert motion.forward_m == pytest.approx(0.03, abs=1e-4)
    assert motion.turn_rad == pytest.approx(0.05, abs=1e-9)
    assert math.hypot(now.x_m - then.x_m, now.y_m - then.y_m) == pytest.approx(
        math.hypot(motion.forward_m, motion.left_m)
    )
    middle = truth.flow_px[60, 80]
    assert middle[1] > 2.0, "what lies ahead moves down the image"
    assert truth.flow_px[:30, :, 0].mean() > 1.0, "turning left moves what lies ahead to the right"
    assert not truth.obstacle.any()


def test_odometry_errs_by_its_scale_and_noise(maps: Path) -> None:
    forward = []
    for seed in range(6):
        outputs, _ = drive(Pymunk(map=maps / "empty.yaml"), Twist(v_mps=0.4, omega_radps=0.0), 60, seed)
        forward.append([o.motion.forward_m / 0.04 for o in outputs[10:] if o.motion is not None])
    means, spreads = np.mean(forward, axis=1), np.std(forward, axis=1)
    assert np.abs(means - 1) == pytest.approx(0.02, abs=0.005)
    assert {*np.sign(means - 1)} == {-1.0, 1.0}
    assert spreads == pytest.approx(0.01, abs=0.004)


@pytest.mark.parametrize("seed", [3, 4, 5])
@pytest.mark.parametrize("name", ["corridor_ccw", "corridor_cw", "pillars", "approach"])
def test_straight_ahead_ends_in_contact(name: str, seed: int, maps: Path) -> None:
    world = Pymunk(map=maps / f"{name}.yaml", size=(32, 24))
    outputs, outcome = drive(world, Twist(v_mps=0.5, omega_radps=0.0), 400, seed)
    assert outcome == "contact"
    assert outputs[-1].state.contact
    assert not outputs[-2].state.contact
    assert outputs[-1].truth is not None, "the last frame is published too"


def test_reaching_the_goal_region_ends_the_run(maps: Path, tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text("start: {at_m: [0, 0], heading_deg: 90}\ngoal: {circle: {center_m: [0, 2], radius_m: 0.5}}\n")
    outputs, outcome = drive(Pymunk(map=path, size=(32, 24)), Twist(v_mps=0.5, omega_radps=0.0), 100)
    assert outcome == "goal"
    assert outputs[-1].state.at_goal
    assert outputs[-1].state.y_m == pytest.approx(1.5, abs=0.06)
    first = outputs[0].goal
    assert first is not None
    assert first.distance_m == pytest.approx(2.0)
    assert first.bearing_rad == pytest.approx(0.0, abs=1e-9)


def test_the_goal_lies_left_where_the_bearing_is_positive(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text("start: {at_m: [0, 0]}\ngoal: {circle: {center_m: [0, 2], radius_m: 0.5}}\n")
    (first,), _ = drive(Pymunk(map=path, size=(32, 24)), None, 1)
    assert first.goal is not None
    assert first.goal.bearing_rad == pytest.approx(math.pi / 2)


def test_a_seed_decides_map_pixels_and_noise(maps: Path) -> None:
    world = Pymunk(map=maps / "corridor_cw.yaml")
    twist = Twist(v_mps=0.3, omega_radps=-0.2)
    one, same, other = (drive(world, twist, 8, seed)[0] for seed in (11, 11, 12))
    for a, b in zip(one, same, strict=True):
        assert (a.image.pixels == b.image.pixels).all()
        assert (a.state.x_m, a.state.clearance_m, a.motion and a.motion.turn_rad) == (
            b.state.x_m,
            b.state.clearance_m,
            b.motion and b.motion.turn_rad,
        )
    assert one[0].map is not None
    assert other[0].map is not None
    assert one[0].map.goal_m.tolist() != other[0].map.goal_m.tolist()
    assert (one[0].image.pixels != other[0].image.pixels).mean() > 0.5


def test_what_the_robot_does_changes_neither_map_nor_textures(maps: Path) -> None:
    world = Pymunk(map=maps / "corridor_ccw.yaml", noise_sigma_gray=0.0)
    straight, _ = drive(world, Twist(v_mps=0.3, omega_radps=0.0), 5)
    turning, _ = drive(world, Twist(v_mps=0.1, omega_radps=1.0), 5)
    assert straight[0].map is not None
    assert turning[0].map is not None
    assert straight[0].map.vertices_m.tolist() == turning[0].map.vertices_m.tolist()
    assert (straight[0].image.pixels == turning[0].image.pixels).all()


@pytest.mark.parametrize("name", sorted(path.stem for path in (shipped_folder() / "maps").glob("*.yaml")))
def test_every_map_that_ships_passes_its_check(name: str, maps: Path) -> None:
    Pymunk(map=maps / f"{name}.yaml").check()


def test_a_missing_map_is_shown_at_its_parameter(tmp_path: Path) -> None:
    with pytest.raises(ParamError, match="'map' is not a file") as caught:
        Pymunk(map=tmp_path / "none.yaml").check()
    assert caught.value.param == "map"


def test_a_wrong_map_is_shown_at_its_own_places(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text("start: {at_m: [0, 0]}\nwals: []\n")
    with pytest.raises(UserError, match=r"map\.yaml:2:1: a map has no key 'wals'"):
        Pymunk(map=path).check()
