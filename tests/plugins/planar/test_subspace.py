"""The motion of the floor is found in the flow, obstacles or not, without odometry."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_planar.gain import Gain
from graphnav_planar.motion import Motion
from graphnav_planar.subspace import Subspace
from graphnav_planar.teach import Teach

from graphnav import Flow, ParamError, Planar, PlanarModel, Stamp
from graphnav.testing import check_stage

if TYPE_CHECKING:
    from tests.plugins.planar.conftest import Floor

Save = Callable[[PlanarModel], Path]
FRAME_US = 100_000
MOTIONS = [(0.0, 0.0), (0.03, 0.0), (0.0, 0.1), (0.03, -0.12), (0.04, 0.16)]


def seen_by(stage: Subspace | Gain, flow: Flow, stamp_us: int = 0) -> Planar:
    return stage.step(flow, Stamp(stamp_us)) if isinstance(stage, Subspace) else stage.step(flow)


@pytest.mark.parametrize(("forward_m", "turn_rad"), MOTIONS)
def test_it_knows_what_exact_odometry_would_tell(
    floor: Floor, model: PlanarModel, save: Save, forward_m: float, turn_rad: float
) -> None:
    told, seen = Motion(model=save(model), odometry_error_ratio=0.0), Subspace(model=save(model))
    for stage in (told, seen):
        stage.reset(0)
    flow = floor.flow(floor.uv_px(forward_m, turn_rad))
    expected = told.step(flow, floor.motion(forward_m, turn_rad))
    assert expected is not None
    # both err by the terms of third order, which the fit may spread over the two that it has
    assert seen.step(flow, Stamp(0)).planar_uv_px == pytest.approx(expected.planar_uv_px, abs=0.1)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("covered", [0.3, 0.5])
def test_obstacles_over_half_of_the_picture_do_not_draw_it(
    floor: Floor, model: PlanarModel, save: Save, covered: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    turn_rad = rng.uniform(-0.12, 0.12)
    exact = floor.uv_px(0.03, turn_rad)
    # what stands on the floor is nearer, the more so the higher: what driving adds to its flow grows
    nearer = rng.uniform(0.1, 0.6, (30, 40, 1)) * (exact - floor.uv_px(0.0, turn_rad))
    seen = np.where(np.arange(40)[:, None] < 40 * covered, exact + nearer, exact) + rng.normal(0, 0.03, exact.shape)
    stage = Subspace(model=save(model))
    stage.reset(seed)
    planar = stage.step(floor.flow(seen), Stamp(0))
    assert np.abs(planar.planar_uv_px - exact).mean() < 0.08


def test_a_sudden_turn_beside_a_wall_is_found_though_the_last_frame_tells_nothing_of_it(
    floor: Floor, model: PlanarModel, save: Save
) -> None:
    straight, turning = floor.uv_px(0.03, 0.0), floor.uv_px(0.03, 0.15)
    wall = np.arange(40)[:, None] < 18
    errors_px = []
    for draws in (0, 16):
        stage = Subspace(model=save(model), draws=draws)
        stage.reset(0)
        stage.step(floor.flow(np.where(wall, 1.4 * straight, straight)), Stamp(0))
        planar = stage.step(floor.flow(np.where(wall, turning + 0.4 * straight, turning)), Stamp(100_000))
        errors_px.append(np.abs(planar.planar_uv_px - turning).mean())
    assert errors_px[1] < 0.1 < errors_px[0]


@pytest.mark.parametrize("kind", [Subspace, Gain])
def test_what_the_flow_gets_wrong_here_and_there_does_not_count(
    floor: Floor, model: PlanarModel, save: Save, kind: type[Subspace | Gain]
) -> None:
    rng = np.random.default_rng(0)
    exact = floor.uv_px(0.03, 0.0)
    seen = np.where(rng.random((30, 40, 1)) < 0.2, rng.uniform(-20, 20, exact.shape), exact)
    stage = kind(model=save(model))
    stage.reset(0)
    assert np.abs(seen_by(stage, floor.flow(seen)).planar_uv_px - exact).max() < 0.15


@pytest.mark.parametrize("kind", [Subspace, Gain])
def test_without_vectors_nothing_is_claimed(
    floor: Floor, model: PlanarModel, save: Save, kind: type[Subspace | Gain]
) -> None:
    stage = kind(model=save(model))
    stage.reset(0)
    blind = replace(floor.flow(floor.uv_px(0.03, 0.0)), valid=np.zeros((30, 40), np.uint8))
    planar = seen_by(stage, blind)
    assert not planar.planar_valid.any()
    assert not planar.planar_uv_px.any()


@pytest.mark.parametrize("kind", [Subspace, Gain])
def test_a_robot_at_rest_has_no_planar_flow(
    floor: Floor, model: PlanarModel, save: Save, kind: type[Subspace | Gain]
) -> None:
    stage = kind(model=save(model))
    stage.reset(0)
    assert np.abs(seen_by(stage, floor.flow(np.zeros((30, 40, 2)))).planar_uv_px).max() < 1e-9


@pytest.mark.parametrize("kind", [Subspace, Gain])
def test_the_stage_keeps_its_contract(
    floor: Floor, model: PlanarModel, save: Save, kind: type[Subspace | Gain]
) -> None:
    steps: list[dict[str, object]] = [{"flow": floor.flow(floor.uv_px(*motion))} for motion in MOTIONS]
    if kind is Subspace:
        steps = [{**step, "stamp": Stamp(FRAME_US * k)} for k, step in enumerate(steps)]
    check_stage(kind, *steps, model=save(model))


def test_one_gain_explains_every_speed(floor: Floor, model: PlanarModel, save: Save) -> None:
    stage = Gain(model=save(model))
    stage.reset(0)
    for forward_m in (0.01, 0.03, 0.06):
        exact = floor.uv_px(forward_m, 0.0)
        left = np.arange(40)[:, None] < 18
        planar = stage.step(floor.flow(np.where(left, 1.4 * exact, exact)))
        assert np.abs(planar.planar_uv_px - exact).max() < 0.05 * np.abs(exact).max()


def test_no_gain_explains_a_turn(floor: Floor, model: PlanarModel, save: Save) -> None:
    stage = Gain(model=save(model))
    stage.reset(0)
    exact = floor.uv_px(0.03, 0.1)
    assert np.abs(stage.step(floor.flow(exact)).planar_uv_px - exact).mean() > 1.0


def test_a_model_that_was_taught_no_turns_is_refused(floor: Floor, save: Save) -> None:
    taught = floor.teach(Teach(terms=("v",)))
    assert taught is not None
    with pytest.raises(ParamError, match="how the flow depends on the motion"):
        Subspace(model=save(taught)).check()


def test_after_a_gap_the_last_frame_tells_nothing(floor: Floor, model: PlanarModel, save: Save) -> None:
    straight, turning = floor.uv_px(0.03, 0.0), floor.uv_px(0.03, 0.15)
    wall = np.arange(40)[:, None] < 18
    before, now = floor.flow(turning), floor.flow(np.where(wall, turning + 0.4 * straight, turning))
    follows, breaks, alone = (Subspace(model=save(model), draws=0) for _ in range(3))
    for stage in (follows, breaks, alone):
        stage.reset(0)
    for stage in (follows, breaks):
        for frame in range(3):
            stage.step(before, Stamp(FRAME_US * frame))
    expected = alone.step(now, Stamp(0)).planar_uv_px
    assert np.array_equal(breaks.step(now, Stamp(FRAME_US * 6)).planar_uv_px, expected)
    assert not np.array_equal(follows.step(now, Stamp(FRAME_US * 3)).planar_uv_px, expected)


@pytest.mark.parametrize(("forward_m", "turn_rad"), MOTIONS)
def test_without_the_turn_it_is_the_flow_of_the_translation(
    floor: Floor, model: PlanarModel, save: Save, forward_m: float, turn_rad: float
) -> None:
    stage = Subspace(model=save(model), with_turn=False)
    stage.reset(0)
    seen = stage.step(floor.flow(floor.uv_px(forward_m, turn_rad)), Stamp(0))
    assert seen.planar_uv_px == pytest.approx(floor.uv_px(forward_m, 0.0), abs=0.1)
