"""Principal components hold what odometry does not tell: how the camera shakes, or all that a robot does."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_planar.motion import Motion
from graphnav_planar.subspace import Subspace
from graphnav_planar.taught import read_model
from graphnav_planar.teach import Teach

from graphnav import ParamError, PlanarModel, Stamp
from graphnav.arrays import Doubles
from graphnav.testing import check_stage

if TYPE_CHECKING:
    from tests.plugins.planar.conftest import Floor

Save = Callable[[PlanarModel], Path]
MOTIONS = [(0.0, 0.0), (0.03, 0.0), (0.0, 0.1), (0.03, -0.12), (0.04, 0.15)]
MODELS = ["shaken_model", "unaided_model"]


@pytest.fixture
def taught(request: pytest.FixtureRequest) -> PlanarModel:
    model: PlanarModel = request.getfixturevalue(request.param)
    return model


def error_px(stage: Subspace, floor: Floor, seen: Doubles, exact: Doubles) -> float:
    """Return the mean difference, px, of the planar flow of a stage that starts with ``seen`` from ``exact``."""
    stage.reset(0)
    return float(np.abs(stage.step(floor.flow(seen), Stamp(0)).planar_uv_px - exact).mean())


def test_components_explain_what_shaking_leaves_of_the_series(floor: Floor, shaken_model: PlanarModel) -> None:
    without = floor.teach(Teach(), noise_px=0.03, with_shake=True)
    assert without is not None
    # a camera that sways moves everything by a pixel a frame; of the components the flow noise remains, 0.03 px in
    # each of two directions, and the terms of third order
    assert np.median(without.residual_px) > 1.0
    assert np.median(shaken_model.residual_px) < 0.08


def test_components_are_orthogonal_and_the_longest_first(unaided_model: PlanarModel) -> None:
    fields = unaided_model.basis[1:].reshape(8, -1).astype(float)
    lengths = np.linalg.norm(fields, axis=1)
    assert (np.diff(lengths) < 0).all()
    # stored as float32, with seven digits
    assert np.abs(fields @ fields.T - np.diag(lengths**2)).max() < 1e-5 * lengths[0] ** 2


@pytest.mark.parametrize("taught", MODELS, indirect=True)
@pytest.mark.parametrize(("forward_m", "turn_rad"), MOTIONS)
@pytest.mark.parametrize("seed", range(3))
def test_the_flow_of_a_floor_is_found_whether_the_camera_shakes_or_not(
    floor: Floor, taught: PlanarModel, save: Save, forward_m: float, turn_rad: float, seed: int
) -> None:
    stage = Subspace(model=save(taught))
    for shake in (floor.shake(np.random.default_rng(seed)), np.zeros(3)):
        exact = floor.uv_px(forward_m, turn_rad, *shake)
        # as much as the series alone leaves of a camera that does not shake
        assert error_px(stage, floor, exact, exact) < 0.08


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("ratio", [0.0, 0.1])
def test_odometry_is_not_asked_how_the_camera_shakes(
    floor: Floor, model: PlanarModel, shaken_model: PlanarModel, save: Save, ratio: float, seed: int
) -> None:
    exact = floor.uv_px(0.03, 0.1, *floor.shake(np.random.default_rng(seed)))
    errors_px = []
    for taught in (model, shaken_model):
        stage = Motion(model=save(taught), odometry_error_ratio=ratio)
        stage.reset(0)
        planar = stage.step(floor.flow(exact), floor.motion(0.03, 0.1))
        assert planar is not None
        errors_px.append(np.abs(planar.planar_uv_px - exact).mean())
    assert errors_px[1] < 0.1 < errors_px[0]


@pytest.mark.parametrize("taught", MODELS, indirect=True)
@pytest.mark.parametrize("covered", [0.2, 0.4])
@pytest.mark.parametrize("seed", range(10))
def test_obstacles_are_not_followed(floor: Floor, taught: PlanarModel, save: Save, covered: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    turn_rad, shake = rng.uniform(-0.12, 0.12), floor.shake(rng)
    exact = floor.uv_px(0.03, turn_rad, *shake)
    # what stands on the floor is nearer, in patches: what driving adds to its flow grows
    nearer = exact + rng.uniform(0.2, 0.6, (30, 40, 1)) * (floor.uv_px(0.03, 0.0))
    patches = rng.random((6, 8)).repeat(5, axis=0).repeat(5, axis=1)[..., None]
    seen = np.where(patches < np.quantile(patches, covered), nearer, exact) + rng.normal(0, 0.03, exact.shape)
    assert error_px(Subspace(model=save(taught)), floor, seen, exact) < 0.1


@pytest.mark.parametrize("seed", range(3))
def test_without_the_turn_it_is_the_flow_of_the_translation_alone(
    floor: Floor, shaken_model: PlanarModel, save: Save, seed: int
) -> None:
    stage = Subspace(model=save(shaken_model), with_turn=False)
    seen = floor.uv_px(0.03, 0.1, *floor.shake(np.random.default_rng(seed)))
    exact = floor.uv_px(0.03, 0.0)
    # driving is told from shaking by what pitch and driving have not in common: a tenth of the speed may be missing
    assert error_px(stage, floor, seen, exact) < 0.1 * np.abs(exact).mean()


def test_a_model_of_components_is_read_as_it_was_taught(unaided_model: PlanarModel, save: Save) -> None:
    model = read_model(save(unaided_model))
    assert model.terms == ("mean", "c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8")
    assert np.array_equal(model.basis, unaided_model.basis)
    assert (model.forward_range_m.tolist(), model.turn_range_rad.tolist()) == ([0.0, 0.0], [0.0, 0.0])


@pytest.mark.parametrize("taught", MODELS, indirect=True)
def test_the_stage_keeps_its_contract(floor: Floor, taught: PlanarModel, save: Save) -> None:
    steps = [
        {"flow": floor.flow(floor.uv_px(*motion)), "stamp": Stamp(100_000 * k)} for k, motion in enumerate(MOTIONS)
    ]
    check_stage(Subspace, *steps, model=save(taught))


def test_odometry_and_components_alone_do_not_go_together(unaided_model: PlanarModel, save: Save) -> None:
    with pytest.raises(ParamError, match=r"taught without odometry: its terms are mean, c1.*\n.*planar\.subspace"):
        Motion(model=save(unaided_model)).check()


def test_components_alone_do_not_tell_the_turn(unaided_model: PlanarModel, save: Save) -> None:
    with pytest.raises(ParamError, match="do not separate turn and translation") as caught:
        Subspace(model=save(unaided_model), with_turn=False).check()
    assert caught.value.param == "with_turn"


def test_a_teacher_without_terms_and_components_is_refused() -> None:
    with pytest.raises(ParamError, match="nothing to teach"):
        Teach(terms=()).check()
    Teach(terms=(), components=1).check()


def test_components_alone_need_no_mean(floor: Floor) -> None:
    model = floor.teach(Teach(terms=(), components=4, every_frames=200), with_motion=False)
    assert model is not None
    assert model.terms == ("c1", "c2", "c3", "c4")
    assert model.valid.all()


@pytest.mark.parametrize("frames", [20, 200])
def test_more_components_than_the_drive_has_are_not_published(floor: Floor, frames: int) -> None:
    """The exact flow of driving straight on has fields of few powers of the displacement; the rest is rounding."""
    stage = Teach(terms=(), components=9, every_frames=frames // 10)
    stage.reset(0)
    flows = [floor.flow(floor.uv_px(forward_m, 0.0)) for forward_m in np.linspace(0.0, 0.04, frames)]
    assert [stage.step(flow) for flow in flows] == [None] * frames
