"""Hints of teaching say what was not driven, or why a model is missing, and are true of the messages of the run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from graphnav import Motion, PlanarModel, load
from graphnav.core.codec import encode
from graphnav.live.teaching import Coverage, Taught, gaps, progress_line, why_no_model

PERIOD_S = 0.1
SILENT = {"channel": "CAMERA", "accepted": 0, "reasons": (), "rejected": (), "details": ()}
WRONG = {"channel": "CAMERA", "accepted": 0, "reasons": ("wrong type",), "rejected": (7,), "details": ("a goal",)}


def taught(*rates: tuple[float, float], residuals_px: Sequence[float] = (), flows: int | None = None) -> Taught:
    """Return what a run has taught that drove with these speeds and turning rates."""
    found = Taught(load("teach_downward"), "teach.planar_model")
    for k in range(len(rates) if flows is None else flows):
        found.write("flow.flow", k, b"")
    for k, (v_mps, turn_radps) in enumerate(rates):
        moved = Motion(forward_m=v_mps * PERIOD_S, left_m=0.0, turn_rad=turn_radps * PERIOD_S, interval_us=100_000)
        found.write("robot.motion", k, encode(moved, k, k))
    for k, residual_px in enumerate(residuals_px):
        found.write("teach.planar_model", k, encode(model(residual_px), k, k))
    return found


def model(residual_px: float) -> PlanarModel:
    return PlanarModel(
        terms=("v",),
        basis=np.zeros((1, 2, 3, 2), np.float32),
        valid=np.array([[1, 1, 0], [1, 1, 1]], np.uint8),
        residual_px=np.array([[residual_px, residual_px, 100], [residual_px] * 3], np.float32),
        forward_range_m=np.zeros(2),
        turn_range_rad=np.zeros(2),
        frames=25,
        interval_us=100_000,
        step_px=4,
    )


BOTH = [(0.3, 0.0), (0.1, 0.5), (0.2, -0.5)]


@pytest.mark.parametrize(
    ("rates", "missing"),
    [
        (BOTH, []),
        ([(0.0, 0.0), (0.001, 0.001)], ["the robot stood still"]),
        ([(-0.3, 0.5), (-0.1, -0.5)], ["the robot never drove forward"]),
        ([(0.3, 0.5), (0.31, -0.5)], ["the speed did not vary: 0.30 to 0.31 m/s"]),
        ([(0.3, 0.0), (0.1, 0.05)], ["no turn was driven"]),
        ([(0.3, 0.5), (0.1, 0.05)], ["no turn to the right was driven"]),
        ([(0.3, -0.5), (0.3, 0.0)], ["the speed did not vary: 0.30 to 0.30 m/s", "no turn to the left was driven"]),
        ([], []),
    ],
)
def test_what_was_not_driven_is_named(rates: list[tuple[float, float]], missing: list[str]) -> None:
    assert gaps(taught(*rates)) == missing


def test_why_there_is_no_model() -> None:
    assert why_no_model(taught(), [SILENT]) == "no message on CAMERA: start its sender, or give its URL with --url"
    assert (
        why_no_model(taught(), [WRONG])
        == "no message on CAMERA could be used: 7 wrong type (a goal); correct its sender"
    )
    assert why_no_model(taught(), []).startswith("no flow was computed: ")
    assert why_no_model(taught(flows=5), []).startswith("no motion of a frame is known: ")
    assert why_no_model(taught((0.3, 0.5), (0.1, 0.6)), []) == (
        "no turn to the right was driven; teach for longer, at several speeds, turning to both sides"
    )
    assert why_no_model(taught(*BOTH), []).startswith("3 frames did not determine it: teach for longer")


def test_enough_is_taught_when_each_limit_was_driven_often_and_the_model_settled() -> None:
    wanted = Coverage(0.3, 0.5)
    often = 10 * BOTH
    assert wanted.is_reached(taught(*often, residuals_px=(0.1, 0.101)))
    assert not wanted.is_reached(taught(*often, residuals_px=(0.1, 0.2)))
    assert not wanted.is_reached(taught(*often, residuals_px=(0.1,)))
    assert not wanted.is_reached(taught(*9 * BOTH, residuals_px=(0.1, 0.1)))
    assert not wanted.is_reached(taught(residuals_px=(0.1, 0.1)))
    assert not Coverage(0.31, 0.5).is_reached(taught(*often, residuals_px=(0.1, 0.1)))
    assert not Coverage(0.3, 0.51).is_reached(taught(*often, residuals_px=(0.1, 0.1)))


def test_the_progress_shows_spans_and_what_is_missing() -> None:
    assert progress_line(taught(), 3.2) == "3 s, 0 frames, no model yet"
    assert progress_line(taught((0.3, 0.5), (0.1, 0.0), residuals_px=(0.0514,)), 12.0) == (
        "12 s, 2 frames, v 0.10 to 0.30 m/s, omega 0.00 to 0.50 rad/s, residual 0.051 px, "
        "no turn to the right was driven"
    )


def test_what_was_driven_after_the_newest_model_is_not_taught() -> None:
    found = taught(*10 * BOTH[:2], residuals_px=(0.1, 0.1))
    for k in range(10):
        found.write("robot.motion", k, encode(Motion(0.02, 0.0, -0.05, 100_000), k, k))
    assert not Coverage(0.3, 0.5).is_reached(found)
    found.write("teach.planar_model", 10, encode(model(0.1), 10, 10))
    assert Coverage(0.3, 0.5).is_reached(found)
