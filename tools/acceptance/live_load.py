"""Large and fast cameras live: what is overtaken, how old the frame is that steers, whether it was the newest."""

from __future__ import annotations

import tempfile
from bisect import bisect_left
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from acceptance.drives import say
from acceptance.rig import Rig
from graphnav import Recording

DRIVE_S = 20.0
ON_ITS_WAY_S = 0.02
"""A frame that was published so shortly before another one was taken may still have been on its way."""
CAMERAS: dict[str, tuple[Sequence[str], Sequence[str]]] = {
    "640x480 at 10 Hz, flow.dis fast": (
        ("--set", "robot.size=[640,480]"),
        (
            *("--set", "flow=flow.dis", "--set", "flow.preset=fast"),
            *("--set", "planar.model=models/downward_640x480.lcmlog"),
        ),
    ),
    "160x120 at 30 Hz, flow.lucas_kanade": (("--set", "robot.image_hz=30"), ()),
}


def load_item(seeds: Sequence[int], _jobs: int) -> bool:
    """Drive each camera over the first three seeds; print overtaken frames, ages, and newer frames passed over."""
    passed = True
    for name in CAMERAS:
        drives = [_drive(name, seed) for seed in seeds[:3]]
        frames, used, passed_over = (sum(drive[k] for drive in drives) for k in range(3))
        ages_ms = np.concatenate([drive[3] for drive in drives])
        p50, p99 = np.quantile(ages_ms, [0.5, 0.99])
        good = passed_over == 0
        passed &= good
        say(
            f"{'ok  ' if good else 'MISS'} {name}: {frames} frames came, {frames - used} overtaken "
            f"({1 - used / frames:.3f}); age of the frame that steered: p50 {p50:.0f}, p99 {p99:.0f}, "
            f"max {ages_ms.max():.0f} ms; {passed_over} times a newer frame was there"
        )
    return passed


def _drive(name: str, seed: int) -> tuple[int, int, int, np.ndarray[tuple[int], np.dtype[np.float64]]]:
    """Return frames that came, frames used, how often a newer one was there, and ages at the command, ms."""
    robot_options, options = CAMERAS[name]
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        everything = ("--set", "run.record=all")
        with Rig(folder, 1 + seed % 100, seed, (*robot_options, *everything, "--until", str(DRIVE_S + 5))) as rig:
            rig.navigate(options=(*options, *everything))
            rig.finish()
        with (
            Recording(folder / "robot" / "run.lcmlog") as robot,
            Recording(folder / "navigation-0" / "run.lcmlog") as run,
        ):
            published = [event.utime for event in robot.events() if event.channel == "robot.image"]
            stamps = robot.utimes("robot.image")
            delivered = newest = used = passed_over = 0
            taken: list[int] = []
            commanded: list[float] = []
            for event in run.events():
                utime = int.from_bytes(event.data[8:16], "big", signed=True)
                if event.channel == "camera.image":
                    newest, delivered = utime, event.utime
                elif event.channel == "flow.flow":
                    used += 1
                    there = bisect_left(published, delivered - ON_ITS_WAY_S * 1e6)
                    passed_over += utime != newest or (there > 0 and stamps[there - 1] > utime)
                    taken.append(utime)
                elif event.channel == "control.twist":
                    commanded.append((event.utime - utime) / 1e3)
            came = sum(taken[0] <= utime <= taken[-1] for utime in stamps)
    return came, used, passed_over, np.array(commanded)
