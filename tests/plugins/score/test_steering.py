"""Which frames count for the sign of the steering, and what counts as right."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pytest
from graphnav_score.steering import Steering as SteeringScore

from graphnav import Steering, Truth

MakeTruth = Callable[..., Truth]


def summary(truth: Truth, to_the_right: float) -> Mapping[str, float]:
    force = np.array([to_the_right, 1.0])
    stage = SteeringScore()
    stage.reset(seed=0)
    stage.step(
        Steering(repulsive=force, guiding=force, control=force, theta_rad=-to_the_right, eigenvalues=np.zeros(2)),
        truth,
    )
    return stage.summary()


def obstacle(left_cols: int, right_cols: int, cols: int = 100) -> np.ndarray:
    mask = np.zeros((10, cols))
    mask[:, :left_cols] = 1
    mask[:, cols - right_cols :] = 1
    return mask


@pytest.mark.parametrize(("force", "right"), [(-0.3, 1.0), (0.3, 0.0), (0.0, 0.0)])
def test_obstacle_on_the_right_asks_for_a_force_to_the_left(make_truth: MakeTruth, force: float, right: float) -> None:
    assert summary(make_truth(obstacle(5, 20)), force) == {"frames": 1.0, "right_sign_ratio": right}
    assert summary(make_truth(obstacle(20, 5)), -force) == {"frames": 1.0, "right_sign_ratio": right}


@pytest.mark.parametrize(
    ("left", "right", "counts"),
    [(5, 0, True), (4, 0, False), (10, 5, True), (10, 6, False), (0, 0, False), (30, 30, False), (30, 15, True)],
)
def test_frames_count_whose_sides_differ_clearly(make_truth: MakeTruth, left: int, right: int, counts: bool) -> None:
    metrics = summary(make_truth(obstacle(left, right)), 1.0)
    assert metrics["frames"] == counts
    assert ("right_sign_ratio" in metrics) == counts


def test_middle_column_belongs_to_no_side(make_truth: MakeTruth) -> None:
    mask = np.zeros((10, 5))
    mask[:, 2] = 1
    assert summary(make_truth(mask), 1.0) == {"frames": 0.0}
    assert summary(make_truth(np.ones((3, 1))), 1.0) == {"frames": 0.0}


def ratio_of(make_truth: MakeTruth, eigenvalues: Sequence[tuple[float, float]]) -> float | None:
    stage = SteeringScore()
    stage.reset(seed=0)
    force = np.array([0.0, 1.0])
    for pair in eigenvalues:
        stage.step(
            Steering(repulsive=force, guiding=force, control=force, theta_rad=0.0, eigenvalues=np.array(pair)),
            make_truth(np.zeros((4, 4))),
        )
    return stage.summary().get("median_eigenvalue_ratio")


def test_eigenvalue_ratio_is_the_median_over_frames_with_a_gradient(make_truth: MakeTruth) -> None:
    assert ratio_of(make_truth, [(4.0, 2.0), (9.0, 1.0), (0.0, 0.0), (3.0, 3.0)]) == 2.0
    assert ratio_of(make_truth, [(4.0, 2.0), (9.0, 0.0), (3.0, 1.0)]) == 3.0, "one direction alone is the surest"
    assert ratio_of(make_truth, [(9.0, 0.0)]) is None
    assert ratio_of(make_truth, [(0.0, 0.0)]) is None
