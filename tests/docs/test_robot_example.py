"""The example of a robot and its navigation in two processes: its commands run, and the robot drives."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from graphnav import Recording

from .conftest import DOCS, blocks, shell


@pytest.mark.long
def test_the_navigation_drives_the_robot(tmp_path: Path, group: str) -> None:
    shell("\n".join(blocks(DOCS / "examples" / "robot" / "README.md", "sh")), tmp_path, group)
    live = json.loads((tmp_path / "navigation" / "summary.json").read_text())["live"]
    accepted = {found["name"]: found["accepted"] for found in live["inputs"]}
    assert accepted["camera.image"] > 10
    assert accepted["base.odometry"] > accepted["camera.image"]
    driven = Recording(tmp_path / "robot" / "run.lcmlog")
    speeds_mps = [driven.fields("robot.state", k)["v_mps"] for k in range(driven.count("robot.state"))]
    assert max(speeds_mps) > 0.1
    assert speeds_mps[-1] == 0.0, "the navigation ended with a stop"
