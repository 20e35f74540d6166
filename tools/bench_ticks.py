"""Ticks per second of complete graphs with their logs, against former versions, the two taking turns on one core.

``python tools/bench_ticks.py [ROUNDS]`` prints, for each graph of 0.1.0 as a robot runs it (without score stages) and
with its scores, the median time of a tick in both versions and the ratio of 0.1.0's to today's with its interval.
Beside it, what the guard costs, which came since, and the truth where it is made without a reader, as 0.1.0 did.

Then the graph `navigate`, which 0.1.0 did not have, against 0.7.1: the median, and the time of the slowest of a hundred
ticks. These are processor time, since one tick that another program delays is a slow one.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal, TypedDict

import cv2
import numpy as np
import yaml  # noqa: TID251 - a graph is copied without a stage; its places do not matter
from graphnav_world.world import Pymunk
from reference_version import ROOT, reference_python
from taking_turns import Ratio, Turns, load_told, results_in_turn

from graphnav import Latest, Stamp, Twist
from graphnav.core.machine.threads import ONE_THREAD

TURN = 25
"""Ticks of a turn."""
SEED = 1000
NAVIGATE_REFERENCE = "0fffacb3"
"""Version 0.7.1, the first reference of the graph `navigate`."""
ROUNDS_OF_PART = 10
"""Turns of which the slowest of a hundred ticks is told to say how much it varies."""
VIDEO_SIZE = (320, 240)
VIDEO_FRAMES = 200
GRAPHS = Path("graphs") / "graphnav_graphs"
_WARM_UP_TURNS = 2
_COLD_TICKS = 3
"""The first ticks of a turn, in which the caches hold the other version's code and data; they do not count as slow."""
_CLOCKS: tuple[Literal["wall_s", "cpu_s"], ...] = ("wall_s", "cpu_s")


class Turn(TypedDict):
    """Times in a turn, s: means of a tick, with its share of the writing of the log, and of each tick alone."""

    wall_s: float
    cpu_s: float
    each_cpu_s: list[float]


@dataclass(frozen=True)
class Speed:
    """A graph in a former version and today: a tick's time in ms, and their ratio."""

    name: str
    old_ms: float
    new_ms: float
    ratio: Ratio
    limit: float | None
    """The minimum of the ratio, None where it is reported only."""
    cpu_ratio: float
    """The ratio of processor time, which other programs on the machine hardly change."""

    def __str__(self) -> str:
        limit = "" if self.limit is None else f"  at least {self.limit:g}"
        return (
            f"{self.name:42} {self.old_ms:6.2f} ms, now {self.new_ms:6.2f} ms ({1e3 / self.new_ms:4.0f} ticks/s): "
            f"{self.ratio}, of processor time {self.cpu_ratio:.2f}{limit}"
        )


def measure(rounds: int = 40) -> Iterator[Speed]:
    """Yield the speeds one after another."""
    python = reference_python()
    with tempfile.TemporaryDirectory() as scratch:
        old = copied_graphs(python.parents[2] / "source" / GRAPHS, Path(scratch) / "old")
        new = copied_graphs(ROOT / GRAPHS, Path(scratch) / "new")
        video = Path(scratch) / "drive.mp4"
        film(video)
        for graph, floor in (("corridor_ccw", 1.7), ("pillars", 1.7)):
            bare = without_scores(old / f"{graph}.yaml"), without_scores(new / f"{graph}.yaml")
            yield _compared(f"{graph} as a robot runs it", python, *bare, rounds, 2.0)
            yield _compared(f"{graph} with scores", python, old / f"{graph}.yaml", new / f"{graph}.yaml", rounds, floor)
            unguarded = _without_guard(bare[1])
            yield _compared("  without scores, without the guard", python, bare[0], unguarded, rounds, None)
            yield _compared("  without scores, truth made", python, bare[0], _with_truth(bare[1]), rounds, None)
        films = [filmed(folder / "video_plane.yaml", video) for folder in (old, new)]
        yield _compared(f"video_plane, {VIDEO_SIZE[0]}x{VIDEO_SIZE[1]}", python, films[0], films[1], rounds, 1.2)
        alike = _with_plane_of_then(films[1])
        yield _compared("  with the flow's parameters and the plane of 0.1.0", python, films[0], alike, rounds, None)
    yield from _navigate(rounds)


def _navigate(rounds: int) -> Iterator[Speed]:
    """Yield the median and the slowest of a hundred ticks of the graph `navigate`, against 0.7.1."""
    python = reference_python(NAVIGATE_REFERENCE)
    with tempfile.TemporaryDirectory() as scratch:
        old = copied_graphs(python.parents[2] / "source" / GRAPHS, Path(scratch) / "old")
        new = copied_graphs(ROOT / GRAPHS, Path(scratch) / "new")
        found = _turns(python, old / "navigate.yaml", new / "navigate.yaml", rounds)
    for name, percent, limit in (("median", 50, 2.0), ("slowest of 100", 99, 3.0)):
        old_ms, new_ms = (1e3 * _percentile(found[version], percent) for version in ("old", "new"))
        ratio = _ratio(found, percent)
        yield Speed(f"navigate against 0.7.1, {name}", old_ms, new_ms, ratio, limit, ratio.median)


def _ratio(found: Mapping[str, Sequence[Turn]], percent: float) -> Ratio:
    """Return the ratio of a percentile of all ticks, with the minimum and maximum of parts of the measurement."""
    parts = [
        {name: turns[k : k + ROUNDS_OF_PART] for name, turns in found.items()}
        for k in range(0, len(found["old"]), ROUNDS_OF_PART)
    ]
    ratios = [_percentile(one["old"], percent) / _percentile(one["new"], percent) for one in [found, *parts]]
    return Ratio(ratios[0], min(ratios), max(ratios))


def _percentile(turns: Sequence[Turn], percent: float) -> float:
    """Return a percentile of the processor times of all ticks, s."""
    return float(np.percentile([each_s for turn in turns for each_s in turn["each_cpu_s"][_COLD_TICKS:]], percent))


def _compared(name: str, python: Path, old: Path, new: Path, rounds: int, limit: float | None) -> Speed:
    """Let a graph of each version take turns."""
    found = _turns(python, old, new, rounds)
    wall, cpu = (Turns({name: [one[key] for one in turns] for name, turns in found.items()}) for key in _CLOCKS)
    old_ms, new_ms = (1e3 * wall.median(name) for name in found)
    return Speed(name, old_ms, new_ms, wall.ratio("old", "new"), limit, cpu.median("old") / cpu.median("new"))


def _turns(python: Path, old: Path, new: Path, rounds: int) -> dict[str, list[Turn]]:
    """Return the turns of each version, old and new."""
    with ExitStack() as stack:
        then = stack.enter_context(ticker(str(python), old))
        now = stack.enter_context(ticker(sys.executable, new))
        rivals = {"old": partial(ticked, then), "new": partial(ticked, now)}
        return results_in_turn(rivals, rounds, warm_up=_WARM_UP_TURNS)


@contextmanager
def ticker(python: str, graph: Path) -> Iterator[subprocess.Popen[str]]:
    """Start a process that ticks a graph by turns, all of them on one core."""
    command = [python, "-P", str(Path(__file__).with_name("tick_turns.py")), str(graph), f"{graph}.lcmlog", str(SEED)]
    with subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | ONE_THREAD,
    ) as process:
        yield process
        assert process.stdin is not None
        process.stdin.close()
    Path(f"{graph}.lcmlog").unlink()


def ticked(process: subprocess.Popen[str]) -> Turn:
    """Return the times of the ticks of a turn."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(f"{TURN}\n")
    process.stdin.flush()
    turn: Turn = json.loads(process.stdout.readline())
    return turn


def copied_graphs(graphs: Path, folder: Path) -> Path:
    """Return a copy of the shipped graphs, in which variants can stand beside what they name."""
    return Path(shutil.copytree(graphs, folder))


def without_scores(graph: Path) -> Path:
    """Return a copy of a graph as a robot runs it."""
    kept = _read(graph)
    kept["stages"] = {name: stage for name, stage in kept["stages"].items() if not stage["use"].startswith("score.")}
    return _written(kept, graph, "bare")


def _without_guard(graph: Path) -> Path:
    kept = _read(graph)
    del kept["stages"]["guard"]
    kept["stages"]["robot"]["in"]["command"] = "control.twist"
    return _written(kept, graph, "unguarded")


def _with_truth(graph: Path) -> Path:
    kept = _read(graph)
    kept["stages"]["robot"]["with"]["truth"] = True
    return _written(kept, graph, "truth")


def _with_plane_of_then(graph: Path) -> Path:
    kept = _read(graph)
    kept["stages"]["flow"]["with"] = {"layers": 5, "min_texture_gray2": 0.5}
    kept["stages"]["plane"] |= {"use": "plane.affine", "with": {"threshold_px": 0.5}}
    return _written(kept, graph, "alike")


def filmed(graph: Path, video: Path) -> Path:
    """Return a copy of `video_plane` that reads a video of `film`."""
    kept = _read(graph)
    camera = kept["stages"]["camera"]["with"]
    camera["path"] = str(video)
    camera.pop("crop_top_ratio", None)  # this camera looks down, and former versions do not crop
    return _written(kept, graph, "film")


def _read(graph: Path) -> dict[str, Any]:
    read: dict[str, Any] = yaml.safe_load(graph.read_text())
    return read


def _written(graph: Mapping[str, Any], source: Path, label: str) -> Path:
    path = source.with_name(f"{source.stem}_{label}.yaml")
    path.write_text(yaml.safe_dump(dict(graph), sort_keys=False))
    return path


def film(path: Path) -> None:
    """Film a drive along the corridor, which turns gently."""
    world = Pymunk(map=ROOT / GRAPHS / "maps" / "corridor_ccw.yaml", size=VIDEO_SIZE)
    world.reset(SEED)
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, VIDEO_SIZE, isColor=False)
    for k in range(VIDEO_FRAMES):
        turn = Twist(v_mps=0.1, omega_radps=0.2 * (-1) ** (k // 20))
        writer.write(world.step(Latest(turn, age_s=0.0), Stamp(100_000 * k)).image.pixels)
    writer.release()
    world.close()


def main(rounds: int = 40) -> int:
    """Print every speed; return 1 if one is below its minimum."""
    missed = 0
    for speed in measure(rounds):
        is_missed = speed.limit is not None and speed.ratio.median < speed.limit
        missed += is_missed
        sys.stdout.write(f"{'MISS' if is_missed else 'ok  '} {speed}\n")
        sys.stdout.flush()
    return 1 if missed else 0


if __name__ == "__main__":
    with load_told():
        sys.exit(main(*map(int, sys.argv[1:])))
