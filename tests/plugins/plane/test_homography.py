"""The homography is the plane's, wherever the camera looks and whatever was computed before."""

from __future__ import annotations

import sys
from dataclasses import replace
from subprocess import run
from typing import TYPE_CHECKING

import cv2
import numpy as np
import pytest
from graphnav_plane.affine import Affine
from graphnav_plane.homography import Homography, least_squares

from graphnav import Flow, FlowDeviation, Plane, Stamp
from graphnav.arrays import Doubles

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scenes

METHODS = ["usac_magsac", "usac_default", "ransac", "lmeds"]


def tilted_floor(perspective_px: float, drive_px: float = 2.0) -> Doubles:
    """Return the flow (30, 40, 2) of a floor under a tilted camera: exactly a homography's.

    ``perspective_px``: what the perspective part adds in the picture's corners.
    """
    y, x = np.mgrid[:30, :40] * 4.0 - np.array([58.0, 78.0])[:, None, None]
    moved = np.stack([1.01 * x + 0.02 * y, -0.02 * x + 1.02 * y + drive_px])
    moved /= 1 + perspective_px / 6000 * y
    return np.stack([moved[0] - x, moved[1] - y], axis=-1)


def seen(stage: Homography | Affine, flow: Flow) -> Plane:
    stage.reset(0)
    return stage.step(flow, Stamp(0))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("drive_px", [0.3, 2.0])
def test_the_score_is_what_stands_out_of_the_homography(scenes: Scenes, method: str, drive_px: float) -> None:
    uv_px = tilted_floor(2.0, drive_px)
    uv_px[:, 30:, 0] += 0.5
    plane = seen(Homography(method=method), scenes.flow(uv_px))  # type: ignore[arg-type]
    assert plane.score[:, 30:] == pytest.approx(np.full((30, 10), 0.5), abs=1e-3)
    assert plane.score[:, :30] == pytest.approx(np.zeros((30, 30)), abs=1e-3)


def test_a_tilted_floor_that_no_affine_motion_explains_is_ground(scenes: Scenes) -> None:
    flow = scenes.flow(tilted_floor(4.0))
    assert seen(Affine(mad_ratio=4.0), flow).score.mean() > 0.1
    plane = seen(Homography(), flow)
    assert plane.score.max() < 1e-3
    assert not plane.obstacle.any()


@pytest.mark.parametrize("share", [0.05, 0.1])
def test_what_draws_the_first_homography_hardly_matters_after_the_refits(scenes: Scenes, share: float) -> None:
    flow = scenes.scene(share, turn_rad=0.03).flow
    scores = [seen(Homography(method=method), flow).score for method in METHODS]  # type: ignore[arg-type]
    for score in scores[1:]:
        assert np.abs(score - scores[0]).mean() < 0.01


@pytest.mark.parametrize("method", METHODS)
def test_neither_order_nor_opencv_generators_change_it(scenes: Scenes, method: str) -> None:
    flow, other = scenes.scene(0.25).flow, scenes.scene(0.1, seed=3).flow
    stage = Homography(method=method)  # type: ignore[arg-type]
    first = seen(stage, flow).score.tobytes()
    cv2.setRNGSeed(12345)
    seen(stage, other)
    cv2.randu(np.zeros(10), 0, 1)
    assert seen(stage, flow).score.tobytes() == first


def test_another_process_gives_the_same_bytes(scenes: Scenes) -> None:
    code = (
        "import sys; from tests.plugins.plane.conftest import Scenes; from graphnav_plane.homography import Homography;"
        "stage = Homography(); stage.reset(0);"
        "sys.stdout.buffer.write(stage.step(Scenes().scene(0.25).flow, 0).score.tobytes())"
    )
    other = run([sys.executable, "-c", code], check=True, capture_output=True).stdout
    assert other == seen(Homography(), scenes.scene(0.25).flow).score.tobytes()


def test_a_flow_in_which_nothing_agrees_is_still_judged(scenes: Scenes) -> None:
    scene = scenes.scene()
    rng = np.random.default_rng(0)
    wild = replace(scene.flow, uv_px=rng.normal(0, 50, scene.flow.uv_px.shape).astype(np.float32))
    plane = seen(Homography(), wild)
    assert plane.not_finite() is None
    assert plane.valid.all()


@pytest.mark.parametrize("noise_px", [0.0, 0.1])
def test_least_squares_is_opencvs(noise_px: float) -> None:
    rng = np.random.default_rng(1)
    places = rng.uniform(-80, 80, (500, 2))
    moved = (
        np.column_stack([places, np.ones(500)]) @ np.array([[1.01, 0.02, 0.3], [-0.02, 1.02, 2.0], [1e-5, 1e-4, 1]]).T
    )
    targets = moved[:, :2] / moved[:, 2:] + rng.normal(0, noise_px, (500, 2))
    ours = least_squares(places, targets, np.ones(len(places)))
    reference, _ = cv2.findHomography(places, targets, 0)
    for corner in ([-80, -60, 1], [80, -60, 1], [80, 60, 1], [0, 0, 1]):
        one, other = ours @ corner, reference @ corner
        # OpenCV minimizes distances, not equations: they differ by a tenth of what noise leaves to chance
        assert one[:2] / one[2] == pytest.approx(other[:2] / other[2], abs=1e-6 + 0.02 * noise_px)


def test_least_squares_of_places_on_a_line_takes_them_where_they_go() -> None:
    places = np.column_stack([np.linspace(-50, 50, 6), np.zeros(6)])
    targets = places + np.array([0.5, 1.0])
    moved = np.column_stack([places, np.ones(6)]) @ least_squares(places, targets, np.ones(len(places))).T
    assert moved[:, :2] / moved[:, 2:] == pytest.approx(targets, abs=1e-3)


def test_a_vector_that_is_likely_to_be_off_counts_for_less_in_the_fit() -> None:
    rng = np.random.default_rng(0)
    shape, step_px = (20, 20), 4
    flow = np.full((*shape, 2), (2.0, 1.0), np.float32)
    deviation_px = np.full(shape, 0.02, np.float32)
    bad = np.s_[:, :14]
    flow[bad] += rng.normal(0.0, 0.3, flow[bad].shape)
    deviation_px[bad] = 0.4
    message = Flow(uv_px=flow, valid=np.ones(shape, np.uint8), interval_us=100_000, step_px=step_px)

    def error_px(deviation: FlowDeviation | None) -> float:
        stage = Homography(cell_px=step_px)
        stage.reset(0)
        return float(stage.step(message, Stamp(0), deviation).score[:, 14:].mean())

    assert error_px(FlowDeviation(deviation_px=deviation_px, step_px=step_px)) < 0.5 * error_px(None)
