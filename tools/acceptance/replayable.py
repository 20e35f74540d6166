"""A replayable log is small, and a replay makes the full one of it."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from acceptance.drives import GRAPHNAV, say
from graphnav import Recording
from graphnav.record import ABOUT, LOG

DRIVES = (("corridor_ccw", 15.0), ("pillars", 15.0), ("approach", 10.0))
"""Graphs, and seconds of each."""
MAX_RATIO = 0.2
"""Of the sizes of the replayable and the full log."""
N_SEEDS = 3


def replayable_item(seeds: Sequence[int], _jobs: int) -> bool:
    """Record each drive in full and replayable; print the sizes, and whether the replay makes the full log."""
    passed = True
    for graph, until_s in DRIVES:
        for seed in seeds[:N_SEEDS]:
            with tempfile.TemporaryDirectory() as scratch:
                found = _compared(graph, until_s, seed, Path(scratch))
            is_good = found.n_differing == 0 and found.ratio <= MAX_RATIO
            passed &= is_good
            say(
                f"{'ok  ' if is_good else 'MISS'} {graph}, seed {seed}, {until_s:g} s: {found.kept_bytes / 1e6:.1f} of "
                f"{found.full_bytes / 1e6:.1f} MB, ratio {found.ratio:.3f} (at most {MAX_RATIO}); "
                f"{found.n_differing} of {found.n_messages} messages differ from the full log"
            )
    return passed


class _Compared(NamedTuple):
    """The sizes of the logs of one drive, and how many messages of the full one the replay does not make."""

    full_bytes: int
    kept_bytes: int
    n_messages: int
    n_differing: int

    @property
    def ratio(self) -> float:
        """The size of the replayable log as a share of the full one."""
        return self.kept_bytes / self.full_bytes


def _compared(graph: str, until_s: float, seed: int, folder: Path) -> _Compared:
    full, kept = (_drive(graph, until_s, seed, record, folder) for record in ("all", "replayable"))
    made = folder / "made.lcmlog"
    subprocess.run([str(GRAPHNAV), "replay", str(kept.parent), "-o", str(made)], check=True, capture_output=True)
    expected, found = _events(full), _events(made)
    n_differing = sum(one != other for one, other in zip(expected, found, strict=False))
    n_differing += abs(len(expected) - len(found))
    return _Compared(full.stat().st_size, kept.stat().st_size, len(expected), n_differing)


def _drive(graph: str, until_s: float, seed: int, record: str, folder: Path) -> Path:
    command = [str(GRAPHNAV), "run", graph, "--seed", str(seed), "--until", str(until_s), "--no-tap", "--no-pictures"]
    command += ["--set", f"run.record={record}", "-o", str(folder / record)]
    subprocess.run(command, check=True, capture_output=True)
    return folder / record / LOG


def _events(log: Path) -> list[tuple[str, int, bytes]]:
    with Recording(log) as recording:
        return [(one.channel, one.utime, one.data) for one in recording.events() if one.channel != ABOUT]
