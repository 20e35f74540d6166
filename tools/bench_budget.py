"""Measure graphs on a share of a core, by a quota of the kernel: what a smaller computer can do, not extrapolated.

A processor that is k times slower is a core of which 1/k may be used: in every 10 ms the processes may run for that
share of them, then they are held up until the next. So short a period comes near to a slower processor; a step is held
up for 11 ms at a time with half a core, 16 ms with a quarter and 43 ms with a tenth (the kernel lets a process overrun
its share a little, and takes it back). Caches and memory stay as fast as they are.

The first table is ticks per second as fast as it goes, world included where the graph has one; the second one drives
`navigate` live: the robot and its world run outside the quota, by the wall clock, what steers has the share alone.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from bench_ticks import GRAPHS, copied_graphs, film, filmed, ticked, ticker, without_scores
from reference_version import ROOT
from testbed.drives import GRAPHNAV
from testbed.rig import summary_of

from graphnav.core.machine import CpuQuota

SHARES = (100, 50, 25, 10)
"""Percent of a core."""
N_TURNS = 3
MAX_DRIVE_S = {0.3: 150, 1.0: 60}
"""The time of a drive by its speed, m/s; the field of pillars is 10 m long."""
DRIVES = ((10, 0.3), (20, 1.0))
"""Images a second, and m/s."""
SEED = 7
_START_S = 5.0
STEERING = """
extends: navigate_robot
inputs: {{base.goal: {{channel: BEACON, type: graphnav_lcm.goal_t}}}}
stages:
  steer:   {{in: {{goal: base.goal}}}}
  control: {{with: {{max_speed_mps: {speed}, max_turn_radps: {turn}}}}}
  guard:   {{with: {{max_speed_mps: 1.2, max_turn_radps: 3}}}}
"""
TURN_RADPS = {0.3: 1.2, 1.0: 2.0}


@dataclass(frozen=True)
class Drive:
    """A live drive on a share of a core: how it ended, and what became of the images.

    ``images`` came, of which so many were ``overtaken`` by newer ones before a step took them.
    """

    rate_hz: int
    speed_mps: float
    share: int
    outcome: str
    took_s: float
    images: int
    overtaken: int


def rates(scratch: Path) -> Iterator[tuple[str, Mapping[int, float]]]:
    """Yield graphs and their ticks per second by share, the median of turns."""
    graphs = copied_graphs(ROOT / GRAPHS, scratch / "graphs")
    video = scratch / "drive.mp4"
    film(video)
    films = filmed(graphs / "video_plane.yaml", video)
    named = {
        "corridor_ccw as a robot runs it": without_scores(graphs / "corridor_ccw.yaml"),
        "pillars": graphs / "pillars.yaml",
        "navigate": graphs / "navigate.yaml",
        "video_plane, 320x240": films,
    }
    for name, graph in named.items():
        found = {}
        with ticker(sys.executable, graph) as process:
            ticked(process)
            for share in SHARES:
                with CpuQuota(share) as quota:
                    quota.join(process.pid)
                    found[share] = 1 / statistics.median(ticked(process)["wall_s"] for _ in range(N_TURNS))
        yield name, found


def drives(scratch: Path, shares: Sequence[int] = SHARES) -> Iterator[Drive]:
    """Yield live drives through the pillars, each speed by each share."""
    for rate_hz, speed in DRIVES:
        for share in shares:
            yield _drive(Path(tempfile.mkdtemp(dir=scratch)), rate_hz, speed, share)


def _drive(folder: Path, rate_hz: int, speed_mps: float, share: int) -> Drive:
    graph = folder / "steering.yaml"
    graph.write_text(STEERING.format(speed=speed_mps, turn=TURN_RADPS[speed_mps]))
    options = ["--url", "udpm://239.255.82.7:8190?ttl=0", "--no-tap", "--no-pictures", "--json"]
    robot = ["map=maps/pillars.yaml", f"image_hz={rate_hz}", "max_speed_mps=1.0", "max_turn_radps=3.0"]
    sets = [word for one in robot for word in ("--set", f"robot.{one}")]
    words = [str(GRAPHNAV), "run"]
    steer = [*words, str(graph), *options, "-o", str(folder / "steering")]
    drive = [*words, "robot_live", *options, *sets, "--seed", str(SEED), "-o", str(folder / "robot")]
    with ExitStack() as stack:
        quota, world = (stack.enter_context(CpuQuota(one)) for one in (share, 100))
        output = stack.enter_context((folder / "output.txt").open("wb"))
        steering = subprocess.Popen(steer, stdout=output, stderr=output)
        stack.callback(steering.wait)
        stack.callback(steering.terminate)
        _await(folder / "steering" / "run.lcmlog")
        time.sleep(_START_S)  # its start is not measured
        quota.join(steering.pid)
        robot_run = subprocess.Popen([*drive, "--until", str(MAX_DRIVE_S[speed_mps])], stdout=output, stderr=output)
        world.join(robot_run.pid)
        robot_run.wait()
    seen, done = summary_of(folder / "steering"), summary_of(folder / "robot")
    image = next(one for one in seen["live"]["inputs"] if one["name"] == "camera.image")
    overtaken = sum(one["overtaken"] for one in seen["live"]["edges"] if one["name"] == "flow.image")
    return Drive(rate_hz, speed_mps, share, done["outcome"], done["sim_s"], image["accepted"], overtaken)


def _await(path: Path) -> None:
    end_s = time.monotonic() + 60
    while not path.exists() and time.monotonic() < end_s:
        time.sleep(0.1)


def main() -> None:
    """Print both tables."""
    with tempfile.TemporaryDirectory() as scratch:
        print(f"{'ticks per second':34}" + "".join(f"{f'{share} % of a core':>16}" for share in SHARES), flush=True)
        for name, found in rates(Path(scratch)):
            print(f"{name:34}" + "".join(f"{found[share]:16.1f}" for share in SHARES), flush=True)
        print("navigate, live, in the field of pillars: the world runs outside the quota", flush=True)
        for one in drives(Path(scratch)):
            print(
                f"{one.rate_hz:3} Hz {one.speed_mps:g} m/s {one.share:4} % of a core: {one.outcome} after "
                f"{one.took_s:.0f} s; {one.overtaken} of {one.images} images overtaken",
                flush=True,
            )


if __name__ == "__main__":
    main()
