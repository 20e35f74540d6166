"""End-point error, worked by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from graphnav_score.flow import Flow as FlowScore

from graphnav import Flow, Truth

MakeTruth = Callable[..., Truth]


def flow(u_px: np.ndarray, valid: np.ndarray | None = None, step_px: int = 1) -> Flow:
    uv_px = np.stack([u_px, np.zeros_like(u_px)], axis=-1).astype(np.float32)
    judged = np.ones(u_px.shape) if valid is None else valid
    return Flow(uv_px=uv_px, valid=judged.astype(np.uint8), interval_us=100_000, step_px=step_px)


def score_of(**parameters: float) -> FlowScore:
    stage = FlowScore(**parameters)
    stage.reset(seed=0)
    return stage


def test_error_is_pooled_over_valid_vectors(make_truth: MakeTruth) -> None:
    stage = score_of()
    u_px = np.zeros((4, 5))
    u_px[0] = 3.0
    valid = np.ones((4, 5))
    valid[3] = 0
    stage.step(flow(u_px, valid), make_truth(np.zeros((4, 5)), (0.0, 4.0)))
    stage.step(flow(u_px), make_truth(np.zeros((4, 5)), (3.0, 0.0)))
    metrics = stage.summary()
    assert metrics["frames"] == 2
    assert metrics["valid_ratio"] == pytest.approx(35 / 40)
    assert metrics["epe_px"] == pytest.approx((5 * 5.0 + 10 * 4.0 + 15 * 3.0) / 35)
    assert metrics["outlier_ratio"] == pytest.approx(30 / 35)


def test_outliers_are_what_is_off_by_more(make_truth: MakeTruth) -> None:
    stage = score_of(outlier_px=2.0)
    stage.step(flow(np.array([[1.0, 2.0, 2.5, 9.0]])), make_truth(np.zeros((1, 4)), (0.0, 0.0)))
    assert stage.summary()["outlier_ratio"] == 0.5


def test_coarse_flow_is_compared_with_the_mean_of_its_cells(make_truth: MakeTruth) -> None:
    truth = make_truth(np.zeros((4, 4)), (0.0, 0.0))
    truth.flow_px[:, ::2, 0] = 2.0
    stage = score_of()
    stage.step(flow(np.ones((2, 2)), step_px=2), truth)
    assert stage.summary()["epe_px"] == pytest.approx(0.0)


def test_without_a_valid_vector_there_is_no_error(make_truth: MakeTruth) -> None:
    stage = score_of()
    assert stage.summary() == {"frames": 0.0}
    stage.step(flow(np.ones((2, 2)), valid=np.zeros((2, 2))), make_truth(np.zeros((2, 2))))
    assert stage.summary() == {"frames": 1.0, "valid_ratio": 0.0}


def test_flow_of_another_image_is_refused(make_truth: MakeTruth) -> None:
    with pytest.raises(ValueError, match="cannot be compared"):
        score_of().step(flow(np.ones((2, 3))), make_truth(np.zeros((2, 2))))
