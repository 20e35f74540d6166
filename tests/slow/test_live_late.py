"""A live graph with a stage that takes three periods of the camera: it is told, and nothing is queued."""

from __future__ import annotations

import json
import statistics
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from testbed.drives import GRAPHNAV
from testbed.processes import hear
from testbed.rig import Rig

from graphnav import Recording, Status
from tests.targets import Targets

GRAPH = Path(__file__).with_name("late_navigation.yaml")
BUSY_S, PERIOD_S, OTHERS_S = 0.3, 0.1, 0.1
MAX_AGE_S = BUSY_S + PERIOD_S + OTHERS_S
"""A frame waits at most for the next one, and is then worked on; the other stages take less than a period."""
MAX_GROWTH_MB = 5.0
LOOKS_S = (10.0, 30.0)
LOOK_S = 5.0
"""Ages are those of the commands in so many seconds before a look."""


def test_late(targets: Targets, seeds: range, tmp_path: Path) -> None:
    """Drive for 32 s with a stage that is late: where that is reported, and what could grow but does not."""
    with Rig(tmp_path, 211, seeds[0], ("--set", "robot.ends=false", "--until", "45")) as rig:
        navigation = rig.navigate(str(GRAPH), ("--tap", "thin", "--until", "32", "--set", "run.record=all"))
        hear(rig.graph_url, "BASE_CMD")
        time.sleep(LOOKS_S[0])
        top = subprocess.run([str(GRAPHNAV), "top", "--once", "--json"], capture_output=True, text=True, check=True)
        navigation.wait(90)
    printed = (tmp_path / "navigation-0.txt").read_text().splitlines()
    summary = json.loads((tmp_path / "navigation-0" / "summary.json").read_text())
    with Recording(tmp_path / "navigation-0" / "run.lcmlog") as log:
        ages, passed_over = _steering_frames(log)
        memory = [(m.run_s, m.memory_mb) for _, _, m in log.messages("graphnav.status") if isinstance(m, Status)]
    told = [line for line in printed if line.startswith("late: ")]
    runs = [run["status"] for run in json.loads(top.stdout)["runs"] if run["run_id"] == summary["run_id"]]
    in_top = _reported(runs[0]["stages"], runs[0]["edges"]) if runs else (0, 0)
    stage = {"name": "slow"} | summary["stages"]["slow"]
    in_summary = _reported([stage], summary["live"]["edges"])
    memory_mb = [max(mb for run_s, mb in memory if run_s <= look_s) for look_s in LOOKS_S]
    windows = [[age for run_s, age in ages if look_s - LOOK_S < run_s <= look_s] for look_s in LOOKS_S]
    ages_s = [(statistics.median(window), max(window)) for window in windows]
    checks = {
        f"told while it ran: {len(told)} notices, the last: {told[-1] if told else 'none'}": len(told) >= 2,
        f"in top: {in_top[0]} deadlines missed, {in_top[1]} frames overtaken": min(in_top) > 0,
        f"in the summary: {in_summary[0]} deadlines missed, {in_summary[1]} frames overtaken": min(in_summary) > 0,
        f"memory at 10 s {memory_mb[0]:.1f} MB, at 30 s {memory_mb[1]:.1f} MB": (
            memory_mb[1] - memory_mb[0] <= MAX_GROWTH_MB
        ),
        f"age of the frame that steered, since its arrival: median (max) at 10 s {ages_s[0][0]:.3f} "
        f"({ages_s[0][1]:.3f}) s, at 30 s {ages_s[1][0]:.3f} ({ages_s[1][1]:.3f}) s; median at most {MAX_AGE_S:g} s": (
            max(median for median, _ in ages_s) <= MAX_AGE_S
        ),
        f"{passed_over} times a newer frame had come when the slow stage began": passed_over == 0,
    }
    for what, holds in checks.items():
        targets.check(what, good=holds)


def _steering_frames(log: Recording) -> tuple[list[tuple[float, float]], int]:
    """Return when each command was given and how old its frame was then, and how often the newest frame was not used.

    Frames that come while the slow stage is at work are taken, and so recorded, after what it publishes.
    """
    begin_us = next(log.events()).utime
    arrived_us: dict[int, int] = {}
    newest = passed_over = 0
    ages: list[tuple[float, float]] = []
    for event in log.events():
        utime = int.from_bytes(event.data[8:16], "big", signed=True)
        if event.channel == "camera.image":
            newest, arrived_us[utime] = utime, event.utime
        elif event.channel == "slow.image":
            passed_over += utime != newest
        elif event.channel == "control.twist":
            ages.append(((event.utime - begin_us) * 1e-6, (event.utime - arrived_us[utime]) * 1e-6))
    return ages, passed_over


def _reported(stages: Sequence[dict[str, Any]], edges: Sequence[dict[str, Any]]) -> tuple[int, int]:
    """Return the deadlines that the slow stage missed, and the frames that were overtaken before it."""
    missed = next(stage["missed"] for stage in stages if stage["name"] == "slow")
    return missed, sum(edge["overtaken"] for edge in edges if edge["name"] == "slow.image")
