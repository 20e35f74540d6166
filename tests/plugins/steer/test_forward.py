"""The control that always drives straight on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from graphnav_steer.forward import Forward

from graphnav import Plane


def test_forward_ignores_obstacles(make_plane: Callable[..., Plane]) -> None:
    stage = Forward()
    stage.reset(seed=0)
    d = np.zeros((30, 40))
    d[:, 20:] = 1
    steering = stage.step(make_plane(d))
    assert steering.theta_rad == 0.0
    assert list(steering.control) == [0.0, 1.0]
    assert not steering.repulsive.any()
