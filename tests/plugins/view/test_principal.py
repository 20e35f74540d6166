"""The direction drawn into the cloud is the one that the robot was steered by."""

from typing import Any, Literal

import numpy as np
import pytest
from graphnav_steer.pca import Pca
from graphnav_view.panels.potential_panels import principal

from graphnav import Latest, Plane


@pytest.mark.parametrize("about", ["centroid", "zero"])
@pytest.mark.parametrize("columns", [slice(0, 8), slice(30, 40)])
def test_v1_agrees_with_the_repulsive_force(about: Literal["centroid", "zero"], columns: slice) -> None:
    obstacle = np.zeros((30, 40), np.uint8)
    obstacle[:12, columns] = 1
    ones = np.ones_like(obstacle)
    plane = Plane(obstacle=obstacle, score=obstacle.astype(np.float32), valid=ones, step_px=4, obstacle_ratio=0.1)
    build: type[Any] = Pca
    steer = build(about=about, isotropic_ratio=1.0)
    steer.reset(0)
    steering, potential = steer.step(plane, Latest(), Latest())
    cloud = -potential.gradient.reshape(-1, 2).astype(np.float64) * np.array([1.0, -1.0])
    v1 = principal(cloud, steering.eigenvalues).direction
    assert v1 == pytest.approx(steering.repulsive / np.hypot(*steering.repulsive), abs=1e-4)
