"""A drive among those who cross can be made again from its log: where they are depends on the recorded commands."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphnav import Recording, State
from graphnav.core.cli import main
from graphnav.core.run_folder import RunFolder

MAP = """
start: {at_m: [0, 0]}
goal: {circle: {center_m: [8, 0], radius_m: 0.5}}
obstacles:
  - circle: {center_m: [1.5, -0.6], radius_m: 0.15}
    crosses: {through_m: [[1.5, 1]], speed_mps: [0.2, 0.4], within_s: 4}
"""


def test_truth_among_those_who_cross_is_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("map.yaml").write_text(MAP)
    drive = [
        "run",
        "pillars",
        "--set",
        "robot.map=map.yaml",
        "--until",
        "5",
        "--no-tap",
        "--no-pictures",
        "--seed",
        "4",
    ]
    assert main([*drive, "-o", "full", "--set", "run.record=all"]) == 0
    assert main([*drive, "-o", "short", "--set", "run.record=replayable"]) == 0
    # Another detector would drive otherwise: the walk follows the recorded commands.
    main(["replay", "short", "-o", "again.lcmlog", "--set", "plane=plane.all_ground"])
    with Recording(Path("full") / RunFolder.LOG) as full, Recording(Path("again.lcmlog")) as again:
        first, *_, last = [message for _, _, message in full.messages("robot.state")]
        assert isinstance(first, State)
        assert isinstance(last, State)
        assert first.moving[0, 1] == -0.6
        assert last.moving[0, 1] > -0.4, "someone walks"
        truths = [[event.data for event in log.events() if event.channel == "robot.truth"] for log in (full, again)]
        assert len(truths[0]) == 50
        assert truths[0] == truths[1]
