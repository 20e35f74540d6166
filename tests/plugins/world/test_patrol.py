"""Where a moving obstacle is."""

from __future__ import annotations

import numpy as np
import pytest
from graphnav_world.geometry.patrol import Patrol


@pytest.mark.parametrize("around", [True, False])
@pytest.mark.parametrize("ahead_m", [0.0, 1.3])
def test_it_runs_along_its_path_at_its_speed(around: bool, ahead_m: float) -> None:
    through = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.5, 2.0]])
    patrol = Patrol(through, 0.4, around, ahead_m)
    stops = np.concatenate([through, through[:1] if around else through[-2::-1]])
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(stops, axis=0), axis=1))])
    for time_s in np.concatenate([[0.0, 5.0], np.random.default_rng(0).uniform(0, 100, 200)]):
        here = (ahead_m + 0.4 * time_s) % run[-1]
        expected = np.interp(here, run, stops[:, 0]), np.interp(here, run, stops[:, 1])
        assert patrol.at(float(time_s)) == pytest.approx(expected, abs=1e-12)


def test_a_path_without_length_is_a_place() -> None:
    assert Patrol(np.array([[1.0, 2.0], [1.0, 2.0]]), 0.4).at(3.0) == (1.0, 2.0)
