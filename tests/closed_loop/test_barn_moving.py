"""The graph barn_moving: a short drive among moving cylinders, which are where their paths say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from graphnav_world.maps.barn_moving import paths

from graphnav import Recording, State
from graphnav.core.cli import main
from graphnav.core.run_folder import RunFolder


def test_a_drive_begins_among_the_cylinders_of_the_seed_s_world(tmp_path: Path) -> None:
    drive = ["run", "barn_moving", "--seed", "85", "--until", "1.5", "--no-tap", "--no-pictures"]
    main([*drive, "-o", str(tmp_path / "run"), "--set", "run.record=all"])
    with Recording(tmp_path / "run" / RunFolder.LOG) as log:
        found = [(utime, state) for utime, _, state in log.messages("robot.state") if isinstance(state, State)]
    cylinders = paths(0, 25)
    begin_us = found[0][0]
    for utime, state in found:
        expected = [path.at((utime - begin_us) * 1e-6) for path in cylinders]
        np.testing.assert_allclose(state.moving[:, :2], expected, atol=1e-12)
    assert len(found) == 31
    assert found[-1][1].y_m > 3.5, "it drives towards the goal"
