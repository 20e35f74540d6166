"""The taught flow is the flow of the floor, for the motion that odometry and the flow itself tell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_planar.mean import Mean
from graphnav_planar.motion import Motion
from graphnav_planar.taught import read_model
from graphnav_planar.teach import Teach

from graphnav import Flow, Image, ParamError, PlanarModel, Stage
from graphnav.core.graph import shipped_folder

if TYPE_CHECKING:
    from tests.plugins.planar.conftest import Floor

Save = Callable[[PlanarModel], Path]
MOTIONS = [(0.0, 0.0), (0.03, 0.0), (0.0, 0.1), (0.03, -0.12), (0.04, 0.16)]


@pytest.mark.parametrize(("forward_m", "turn_rad"), MOTIONS)
def test_the_flow_of_a_motion_is_predicted(
    floor: Floor, model: PlanarModel, save: Save, forward_m: float, turn_rad: float
) -> None:
    stage = Motion(model=save(model), odometry_error_ratio=0.0)
    stage.reset(0)
    exact = floor.uv_px(forward_m, turn_rad)
    planar = stage.step(floor.flow(exact), floor.motion(forward_m, turn_rad))
    assert planar is not None
    assert planar.planar_uv_px == pytest.approx(exact, abs=0.35)
    assert np.abs(planar.planar_uv_px - exact).mean() < 0.08


def test_a_robot_at_rest_has_no_planar_flow(floor: Floor, model: PlanarModel, save: Save) -> None:
    stage = Motion(model=save(model))
    stage.reset(0)
    planar = stage.step(floor.flow(np.zeros((30, 40, 2))), floor.motion(0.0, 0.0))
    assert planar is not None
    assert not planar.planar_uv_px.any()


@pytest.mark.parametrize("scale", [0.95, 1.05])
def test_odometry_that_errs_is_corrected_by_the_floor(
    floor: Floor, model: PlanarModel, save: Save, scale: float
) -> None:
    believing, correcting = Motion(model=save(model), odometry_error_ratio=0.0), Motion(model=save(model))
    exact = floor.uv_px(0.03, 0.1)
    errors_px = []
    for stage in (believing, correcting):
        stage.reset(0)
        planar = stage.step(floor.flow(exact), floor.motion(0.03 * scale, 0.1 / scale))
        assert planar is not None
        errors_px.append(np.abs(planar.planar_uv_px - exact).mean())
    assert errors_px[1] < 0.2 * errors_px[0]


def test_an_obstacle_over_half_of_the_picture_does_not_draw_the_correction(
    floor: Floor, model: PlanarModel, save: Save
) -> None:
    stage = Motion(model=save(model))
    stage.reset(0)
    exact = floor.uv_px(0.03, 0.0)
    seen = np.where(np.arange(40)[:, None] < 22, 1.4 * exact, exact)
    planar = stage.step(floor.flow(seen), floor.motion(0.03 * 1.02, 0.0))
    assert planar is not None
    assert np.abs(planar.planar_uv_px - exact).max() < 0.02


def test_the_correction_stays_within_its_limit(floor: Floor, model: PlanarModel, save: Save) -> None:
    stage = Motion(model=save(model), odometry_error_ratio=0.02)
    stage.reset(0)
    exact = floor.uv_px(0.03, 0.0)
    planar = stage.step(floor.flow(1.04 * exact), floor.motion(0.03, 0.0))
    assert planar is not None
    assert np.abs(planar.planar_uv_px).max() <= 1.021 * np.abs(exact).max()


def test_a_flow_without_a_valid_vector_corrects_nothing(floor: Floor, model: PlanarModel, save: Save) -> None:
    stage = Motion(model=save(model))
    stage.reset(0)
    exact = floor.uv_px(0.03, 0.0)
    blind = replace(floor.flow(2 * exact), valid=np.zeros((30, 40), np.uint8))
    planar = stage.step(blind, floor.motion(0.03, 0.0))
    assert planar is not None
    assert planar.planar_uv_px == pytest.approx(exact, abs=0.05)


def test_the_mean_is_the_same_whatever_the_robot_does(floor: Floor, model: PlanarModel, save: Save) -> None:
    stage = Mean(model=save(model))
    stage.reset(0)
    one, other = (stage.step(floor.flow(floor.uv_px(*motion))) for motion in MOTIONS[1:3])
    assert np.array_equal(one.planar_uv_px, other.planar_uv_px)
    assert one.planar_uv_px == pytest.approx(floor.uv_px(0.03, 0.0), abs=0.4)


def test_the_mean_of_half_the_interval_is_half_as_long(floor: Floor, model: PlanarModel, save: Save) -> None:
    stage = Mean(model=save(model))
    stage.reset(0)
    flow = floor.flow(floor.uv_px(0.03, 0.0))
    full, half = stage.step(flow), stage.step(replace(flow, interval_us=50_000))
    assert half.planar_uv_px == pytest.approx(full.planar_uv_px / 2)


@pytest.mark.parametrize("kind", [Mean, Motion])
def test_what_was_taught_is_passed_on(floor: Floor, model: PlanarModel, save: Save, kind: type[Mean | Motion]) -> None:
    stage = kind(model=save(model))
    stage.reset(0)
    flow = floor.flow(floor.uv_px(0.03, 0.0))
    planar = stage.step(flow) if isinstance(stage, Mean) else stage.step(flow, floor.motion(0.03, 0.0))
    assert planar is not None
    assert np.array_equal(planar.residual_px, model.residual_px)
    assert np.array_equal(planar.planar_valid, model.valid)
    assert (planar.step_px, planar.interval_us) == (4, flow.interval_us)


def test_a_dense_flow_of_the_same_picture_fits(floor: Floor, model: PlanarModel, save: Save) -> None:
    stage = Motion(model=save(model))
    stage.reset(0)
    exact = floor.uv_px(0.03, 0.0)
    dense = Flow(
        uv_px=exact.repeat(4, 0).repeat(4, 1).astype(np.float32),
        valid=np.ones((120, 160), np.uint8),
        interval_us=100_000,
    )
    planar = stage.step(dense, floor.motion(0.0303, 0.0))
    assert planar is not None
    assert planar.planar_uv_px == pytest.approx(exact, abs=0.05)


@pytest.mark.parametrize("kind", [Mean, Motion])
def test_another_picture_size_is_refused(
    floor: Floor, model: PlanarModel, save: Save, kind: type[Mean | Motion]
) -> None:
    stage = kind(model=save(model))
    stage.reset(0)
    flow = floor.flow(np.zeros((60, 80, 2)))
    with pytest.raises(ValueError, match="model is 40x30 cells of 4 px, but the flow is 80x60 cells of 4 px; teach"):
        _ = stage.step(flow) if isinstance(stage, Mean) else stage.step(flow, floor.motion(0.03, 0.0))


def test_a_missing_model_is_named(tmp_path: Path) -> None:
    with pytest.raises(ParamError, match=r"missing\.lcmlog") as caught:
        Motion(model=tmp_path / "missing.lcmlog").check()
    assert caught.value.param == "model"


def test_a_file_that_is_no_log_is_refused(tmp_path: Path) -> None:
    (tmp_path / "text.lcmlog").write_text("not a log at all, but a string that is long enough for an event")
    with pytest.raises(ParamError, match=r"text\.lcmlog") as caught:
        Mean(model=tmp_path / "text.lcmlog").check()
    assert "graphnav teach" in str(caught.value)


def test_a_log_without_a_model_is_refused(tmp_path: Path) -> None:
    from graphnav.core.codec import encode
    from graphnav.core.record import LogWriter

    path = tmp_path / "images.lcmlog"
    writer = LogWriter(path)
    writer.write("camera.image", 0, encode(Image(pixels=np.zeros((8, 8), np.uint8)), 0, 0))
    writer.close()
    with pytest.raises(ParamError, match="holds no planar model"):
        Mean(model=path).check()


@pytest.mark.parametrize(("kind", "terms"), [(Mean, ("v", "w")), (Motion, ("mean",))])
def test_a_model_without_the_terms_that_are_needed_is_refused(
    floor: Floor, save: Save, kind: type[Mean | Motion], terms: tuple[str, ...]
) -> None:
    other = floor.teach(Teach(terms=terms))  # type: ignore[arg-type]
    assert other is not None
    with pytest.raises(ParamError, match=f"its terms are {', '.join(terms)}"):
        kind(model=save(other)).check()


def test_the_shipped_model_serves_every_planar_stage() -> None:
    shipped = shipped_folder() / "models" / "downward_160x120.lcmlog"
    stages: list[Stage] = [Mean(model=shipped), Motion(model=shipped)]
    for stage in stages:
        stage.check()


@pytest.mark.parametrize("path", sorted((shipped_folder() / "models").glob("*.lcmlog")), ids=lambda path: path.stem)
def test_what_a_shipped_model_was_taught_is_the_flow_of_a_floor(path: Path) -> None:
    """The motion that its drive left unexplained is small; where flow could not follow it was more than a pixel."""
    model = read_model(path)
    left_px = float(np.median(model.residual_px[model.valid != 0]))
    assert left_px < 0.2 * (4 if "640x480" in path.stem else 1)


@pytest.mark.parametrize("motion_us", [101_100, 200_000])
def test_a_motion_of_more_than_the_flow_is_refused(
    floor: Floor, model: PlanarModel, save: Save, motion_us: int
) -> None:
    stage = Motion(model=save(model))
    stage.reset(0)
    flow = floor.flow(floor.uv_px(0.03, 0.0))
    said = rf"^the motion covers {motion_us} us, but the flow 100000 us; use odometry.motion, which interpolates"
    with pytest.raises(ValueError, match=said):
        stage.step(flow, replace(floor.motion(0.03, 0.0), interval_us=motion_us))
    stage.step(flow, replace(floor.motion(0.03, 0.0), interval_us=100_900))
