"""Logs of two live runs that drive each other, one with a clock an hour ahead."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from graphnav import Recording
from graphnav.core.cli import main
from tests.watch.merge import hour_ahead

URL = "udpm://239.255.91.10:7920?ttl=0&recv_buf_size=2097152"
RUN_S = 3.0


def words(graph: str, folder: Path) -> list[str]:
    options = ["--url", URL, "--no-tap", "--no-pictures", "--json", "--set", "run.record=replayable"]
    return ["run", graph, *options, "--until", str(RUN_S), "-o", str(folder)]


@pytest.mark.long
def test_the_clock_of_a_run_is_found_and_the_first_log_replays(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot, laptop, target = tmp_path / "robot", tmp_path / "laptop", tmp_path / "merged.lcmlog"
    commands = [
        [sys.executable, "-m", "graphnav", *words("robot_live", robot)],
        [sys.executable, hour_ahead.__file__, *words("navigate_live", laptop)],
    ]
    runs = [subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for command in commands]
    assert [run.wait(120) for run in runs] == [0, 0]
    assert main(["merge", str(robot), str(laptop), "-o", str(target), "--json"]) == 0
    merged = json.loads(capsys.readouterr().out)
    other = merged["logs"][1]
    assert other["from_there"]
    assert other["back"]
    assert abs(other["ahead_us"] - hour_ahead.AHEAD_US) <= other["error_us"]
    senders = {(way["channel"], way["other_channel"]): way["sender"] for way in other["ways"]}
    assert senders["robot.image", "camera.image"] == "robot"
    assert senders["base.twist", "guard.twist"] == "laptop"
    with Recording(target) as log:
        assert log.n_events == merged["messages"]
        assert log.count("robot.image")
        assert log.count("camera.image")
        assert log.count("laptop.graphnav.fired")
    assert main(["merge", str(laptop), str(robot), "-o", str(target), "--force"]) == 0
    capsys.readouterr()
    assert main(["replay", str(target)]) == 0
    (last,) = re.findall(r"no differences: ([0-9,]+) messages", capsys.readouterr().out)
    assert int(last.replace(",", "")) > 0
