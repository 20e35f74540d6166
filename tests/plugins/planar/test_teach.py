"""Teaching finds how the flow of a floor depends on the motion."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_planar.teach import Teach

from graphnav import ParamError, PlanarModel

if TYPE_CHECKING:
    from tests.plugins.planar.conftest import Floor


def test_the_series_of_second_order_leaves_little_of_an_exact_flow(model: PlanarModel) -> None:
    # what it leaves are the terms of third order: at 1.6 rad/s, in the corners, 0.16**3 / 6 of 100 px
    assert model.residual_px[model.valid > 0].mean() < 0.04
    assert model.residual_px.max() < 0.15


def test_second_order_terms_earn_their_place(floor: Floor, model: PlanarModel) -> None:
    first_order = floor.teach(Teach(terms=("v", "w")))
    assert first_order is not None
    assert model.residual_px.mean() < 0.25 * first_order.residual_px.mean()


def test_the_residual_is_the_noise_of_the_flow(floor: Floor, model: PlanarModel) -> None:
    noisy = floor.teach(Teach(), noise_px=0.2)
    assert noisy is not None
    expected = np.hypot(np.sqrt(2) * 0.2, model.residual_px)
    assert noisy.residual_px.mean() == pytest.approx(expected.mean(), rel=0.05)


def test_mean_is_the_mean_flow_of_driving_straight_on(floor: Floor, model: PlanarModel) -> None:
    straight = floor.uv_px(0.03, 0.0)
    assert np.abs(model.basis[0] - straight).max() < 0.1 * np.abs(straight).max()


def test_the_model_says_what_it_was_taught_from(model: PlanarModel) -> None:
    assert (model.frames, model.step_px, model.interval_us) == (200, 4, 100_000)
    assert model.terms == ("mean", "v", "w", "vw", "ww")
    assert model.forward_range_m == pytest.approx([0.0, 0.04], abs=0.003)
    assert model.turn_range_rad == pytest.approx([-0.16, 0.16], abs=0.02)


def test_nothing_is_published_before_the_motion_tells_the_fields_apart(floor: Floor) -> None:
    stage = Teach(terms=("v", "w"), every_frames=1)
    stage.reset(0)
    straight = floor.flow(floor.uv_px(0.03, 0.0)), floor.motion(0.03, 0.0)
    turning = floor.flow(floor.uv_px(0.03, 0.1)), floor.motion(0.03, 0.1)
    assert stage.step(*straight) is None
    assert stage.step(*straight) is None
    assert stage.step(*turning) is not None


def test_a_video_without_motion_teaches_the_mean(floor: Floor) -> None:
    stage = Teach(terms=("mean",), every_frames=2)
    stage.reset(0)
    slow, fast = floor.uv_px(0.01, 0.0), floor.uv_px(0.03, 0.0)
    assert stage.step(floor.flow(slow)) is None
    model = stage.step(floor.flow(fast))
    assert model is not None
    assert np.allclose(model.basis[0], (slow + fast) / 2, atol=1e-5)


def test_terms_of_the_motion_need_the_motion(floor: Floor) -> None:
    stage = Teach()
    stage.reset(0)
    with pytest.raises(ValueError, match="wire 'motion', or, without odometry, teach"):
        stage.step(floor.flow(floor.uv_px(0.03, 0.0)))


def test_cells_that_were_rarely_valid_are_not_taught(floor: Floor) -> None:
    stage = Teach(terms=("mean",), every_frames=1)
    stage.reset(0)
    complete = floor.flow(floor.uv_px(0.03, 0.0))
    holed = replace(complete, valid=np.where(np.arange(40) < 10, 0, complete.valid).astype(np.uint8))
    for flow in (complete, holed, holed):
        model = stage.step(flow)
    assert model is not None
    assert not model.valid[:, :10].any()
    assert model.valid[:, 10:].all()


def test_the_picture_may_not_change_its_size(floor: Floor) -> None:
    stage = Teach(terms=("mean",))
    stage.reset(0)
    complete = floor.flow(floor.uv_px(0.03, 0.0))
    stage.step(complete)
    with pytest.raises(ValueError, match="was 40x30 cells of 4 px, but is 40x20 now"):
        stage.step(replace(complete, uv_px=complete.uv_px[:20], valid=complete.valid[:20]))


def test_an_unknown_term_is_refused() -> None:
    with pytest.raises(ParamError, match="terms"):
        Teach(terms=("v", "vvw"))  # type: ignore[arg-type]


def test_a_flow_of_two_frames_teaches_nothing(floor: Floor) -> None:
    stage = Teach(every_frames=2)
    stage.reset(0)
    flow, motion = floor.flow(floor.uv_px(0.03, 0.0)), floor.motion(0.03, 0.0)
    assert stage.step(flow, replace(motion, interval_us=50_000)) is None
    stage.step(flow, motion)
    assert stage.summary()["frames"] == 1


def test_a_motion_of_another_interval_teaches_nothing(floor: Floor) -> None:
    stage = Teach()
    stage.reset(0)
    moved = replace(floor.motion(0.03, 0.0), interval_us=200_000)
    with pytest.raises(ValueError, match=r"^the motion covers 200000 us, but the flow 100000 us; use odometry.motion"):
        stage.step(floor.flow(floor.uv_px(0.03, 0.0)), moved)
