"""Logs of two runs, one with a clock an hour ahead: the offset that `merge` finds, and latencies."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from testbed.drives import GRAPHNAV

from graphnav import Recording
from tests.targets import Targets
from tests.watch.merge import hour_ahead

URL = "udpm://239.255.91.9:7919?ttl=0&recv_buf_size=2097152"
RUN_S = 60.0


def latency_ms(log: Recording, sent: Recording) -> str:
    """Return how much later the pictures of one log arrived than they left by the other: min, median, max."""
    left = dict(zip(sent.utimes("robot.image"), sent.event_utimes("robot.image"), strict=True))
    arrived = zip(log.utimes("camera.image"), log.event_utimes("camera.image"), strict=True)
    took_ms = np.array([(at_us - left[stamp]) / 1e3 for stamp, at_us in arrived if stamp in left])
    return ", ".join(f"{value:.2f}" for value in np.quantile(took_ms, (0.0, 0.5, 1.0)))


def test_merge(targets: Targets, tmp_path: Path) -> None:
    """Drive for a minute, merge both logs, and replay the merged one."""
    options = ["--url", URL, "--no-tap", "--no-pictures", "--set", "run.record=replayable", "--json"]
    robot, laptop, merged = tmp_path / "robot", tmp_path / "laptop", tmp_path / "merged.lcmlog"
    words = [str(GRAPHNAV), "run", "robot_live", *options, "--until", str(RUN_S + 5), "--set", "robot.ends=false"]
    with subprocess.Popen([*words, "-o", str(robot)], stdout=subprocess.DEVNULL) as driving:
        steer = [sys.executable, hour_ahead.__file__, "run", "navigate_live", *options, "--until", str(RUN_S)]
        subprocess.run([*steer, "-o", str(laptop)], check=True, stdout=subprocess.DEVNULL)
        driving.wait()
    command = [str(GRAPHNAV), "merge", str(robot), str(laptop), "-o", str(merged), "--json"]
    found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["logs"][1]
    off_us = found["ahead_us"] - hour_ahead.AHEAD_US
    targets.say(f"{found['from_there']} messages there, {found['back']} back; drift {found['drift_ppm']:.1f} ppm")
    targets.check(
        f"offset {off_us:.0f} us from the true one, give or take {found['error_us']:.0f} us",
        good=abs(off_us) <= found["error_us"],
    )
    targets.check(f"clocks set: {len(found['set'])}", good=not found["set"])
    with Recording(robot / "run.lcmlog") as sent, Recording(laptop / "run.lcmlog") as received:
        targets.say(f"picture to arrival by the logs as they are: {latency_ms(received, sent)} ms (min, median, max)")
    with Recording(merged) as log:
        targets.say(f"picture to arrival in the merged log: {latency_ms(log, log)} ms (min, median, max)")
    subprocess.run([*command[:2], str(laptop), str(robot), *command[4:], "--force"], check=True, capture_output=True)
    replayed = subprocess.run([str(GRAPHNAV), "replay", str(merged)], check=False, capture_output=True, text=True)
    targets.check(replayed.stdout.strip().splitlines()[-1], good=replayed.returncode == 0)
