"""Planes drawn by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

from graphnav import Plane

MakePlane = Callable[..., Plane]


@pytest.fixture
def make_plane() -> MakePlane:
    """Return what makes a plane of a dominant map (rows, cols), all of it judged unless ``valid`` says otherwise."""

    def make(d: npt.ArrayLike, valid: npt.ArrayLike | None = None) -> Plane:
        obstacle = np.asarray(d, np.uint8)
        judged = np.ones_like(obstacle) if valid is None else np.asarray(valid, np.uint8)
        return Plane(
            obstacle=obstacle,
            score=obstacle.astype(np.float32),
            valid=judged,
            step_px=4,
            obstacle_ratio=float(obstacle.sum() / max(int(judged.sum()), 1)),
        )

    return make
