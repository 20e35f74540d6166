"""The graphs that drive by a lidar set out towards their goal, and render no camera."""

from __future__ import annotations

from pathlib import Path

import pytest

import graphnav
from graphnav import Goal, State


@pytest.mark.parametrize("name", ["lidar_gap", "lidar_rollout"])
def test_it_sets_out(name: str, tmp_path: Path) -> None:
    graphnav.run(name, folder=tmp_path / "run", pictures=False, until_s=4.0, record="all")
    with graphnav.Recording(tmp_path / "run" / "run.lcmlog") as log:
        assert log.count("robot.scan") == 41
        assert "robot.image" not in log.channels or log.count("robot.image") == 0
        first, last = (log.message("robot.goal", index)[2] for index in (0, -1))
        state = log.message("robot.state", -1)[2]
    assert isinstance(first, Goal)
    assert isinstance(last, Goal)
    # At 0.3 m/s it drives 1.1 m in 4 s, with the time to speed up.
    assert first.distance_m - last.distance_m > 0.6
    assert isinstance(state, State)
    assert not state.contact
