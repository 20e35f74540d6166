"""Large and fast cameras live: what is overtaken, how old the frame is that steers, whether it was the newest."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from testbed.rig import Rig

from graphnav import Recording
from graphnav.arrays import Doubles
from graphnav.core.record import Event
from graphnav.core.run_folder import RunFolder
from tests.targets import Targets

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


class Load(NamedTuple):
    """The outcome of the frames of one drive; ``ages_ms``: of those that steered, at the command."""

    came: int
    lost: int
    overtaken: int
    ages_ms: Doubles


@pytest.mark.parametrize("name", CAMERAS)
def test_load(targets: Targets, seeds: range, tmp_path: Path, name: str) -> None:
    """Overtaken frames, ages, and newer frames passed over, of drives of the first three seeds.

    Frames and ages are of drives that record small messages, as live runs do by default. Whether the newest frame was
    used is read from the logs of further drives, which record everything and so are slower; their writer drops what the
    disk does not take.
    """
    loads = [_load(name, seed, tmp_path / f"small-{seed}") for seed in seeds[:3]]
    came, lost, overtaken = (sum(column) for column in zip(*(one[:3] for one in loads), strict=True))
    ages_ms = np.concatenate([one.ages_ms for one in loads])
    p50, p99 = np.quantile(ages_ms, [0.5, 0.99])
    everything = (_passed_over(name, seed, tmp_path / f"all-{seed}") for seed in seeds[:3])
    looked_at, passed_over, dropped = map(sum, zip(*everything, strict=True))
    targets.check(
        f"{name}: {came} frames came, {lost} were lost on the network, {overtaken} overtaken ({overtaken / came:.3f}); "
        f"age of the frame that steered: p50 {p50:.0f}, p99 {p99:.0f}, max {ages_ms.max():.0f} ms; with everything "
        f"recorded ({dropped} messages dropped by the log) a newer frame was there at {passed_over} of {looked_at} "
        "steps",
        good=passed_over == 0 and looked_at > 0,
    )


def _load(name: str, seed: int, folder: Path) -> Load:
    """Drive and record small messages."""
    robot_options, options = CAMERAS[name]
    with Rig(folder, 1 + seed % 100, seed, (*robot_options, "--until", str(DRIVE_S + 5))) as rig:
        rig.navigate(options=options)
        live = rig.finish()[1]["live"]
    with Recording(folder / "navigation-0" / RunFolder.LOG) as run:
        ages = [(event.utime - _utime(event)) / 1e3 for event in run.events() if event.channel == "control.twist"]
    camera = next(one for one in live["inputs"] if one["name"] == "camera.image")
    overtaken = sum(one["overtaken"] for one in live["edges"] if one["name"] == "flow.image")
    return Load(camera["accepted"], camera["lost"], overtaken, np.array(ages))


def _passed_over(name: str, seed: int, folder: Path) -> tuple[int, int, int]:
    """Return how many steps of the flow the log holds, at how many a newer frame was there, and what the log lacks."""
    robot_options, options = CAMERAS[name]
    everything = ("--set", "run.record=all")
    with Rig(folder, 1 + seed % 100, seed, (*robot_options, *everything, "--until", str(DRIVE_S + 5))) as rig:
        rig.navigate(options=(*options, *everything))
        dropped = rig.finish()[1]["live"]["log_dropped"]
    with (
        Recording(folder / "robot" / RunFolder.LOG) as robot,
        Recording(folder / "navigation-0" / RunFolder.LOG) as run,
    ):
        published = [event.utime for event in robot.events() if event.channel == "robot.image"]
        stamps = robot.utimes("robot.image")
        delivered = newest = looked_at = passed_over = 0
        for event in run.events():
            if event.channel == "camera.image":
                newest, delivered = _utime(event), event.utime
            elif event.channel == "flow.flow":
                looked_at += 1
                there = bisect_left(published, delivered - ON_ITS_WAY_S * 1e6)
                passed_over += _utime(event) != newest or (there > 0 and stamps[there - 1] > _utime(event))
    return looked_at, passed_over, dropped


def _utime(event: Event) -> int:
    return int.from_bytes(event.data[8:16], "big", signed=True)
