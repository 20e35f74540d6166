"""Truths, planes and states made by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

from graphnav import Plane, Truth

MakeTruth = Callable[..., Truth]
MakePlane = Callable[..., Plane]


@pytest.fixture
def make_truth() -> MakeTruth:
    """Return what makes a truth of an obstacle mask (rows, cols) and a constant flow."""

    def make(obstacle: npt.ArrayLike, uv_px: tuple[float, float] = (1.0, 0.0)) -> Truth:
        mask = np.asarray(obstacle, np.uint8)
        return Truth(
            obstacle=mask,
            depth_m=np.ones(mask.shape, np.float32),
            flow_px=np.full((*mask.shape, 2), uv_px, np.float32),
            interval_us=100_000,
        )

    return make


@pytest.fixture
def make_plane() -> MakePlane:
    """Return what makes a plane of scores (rows, cols), obstacle where they are above one half."""

    def make(score: npt.ArrayLike, valid: npt.ArrayLike | None = None, step_px: int = 1) -> Plane:
        scores = np.asarray(score, np.float32)
        judged = np.ones(scores.shape, np.uint8) if valid is None else np.asarray(valid, np.uint8)
        obstacle = ((scores > 0.5) & (judged != 0)).astype(np.uint8)
        return Plane(
            obstacle=obstacle, score=scores, valid=judged, step_px=step_px, obstacle_ratio=float(obstacle.mean())
        )

    return make
