"""Drive a graph over many seeds, each in a separate process, and count the outcomes."""

from __future__ import annotations

import json
import subprocess
import sysconfig
import tempfile
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"
Summary = dict[str, Any]


@dataclass(frozen=True)
class Drives:
    """The summaries of one graph with one set of swaps, in the order of the seeds."""

    graph: str
    sets: tuple[str, ...]
    seeds: tuple[int, ...]
    summaries: tuple[Summary, ...]

    def ended(self, outcome: str) -> int:
        """Return the number of drives with this outcome."""
        return sum(summary["outcome"] == outcome for summary in self.summaries)

    def outcomes(self) -> str:
        """Return the outcomes and, for those that are not the most frequent, their seeds."""
        counts = Counter(summary["outcome"] for summary in self.summaries)
        words = []
        for place, (outcome, count) in enumerate(counts.most_common()):
            seeds = [str(seed) for seed, s in zip(self.seeds, self.summaries, strict=True) if s["outcome"] == outcome]
            words.append(f"{outcome} {count}" + (f" (seeds {' '.join(seeds)})" if place else ""))
        return ", ".join(words)


def drive(graph: str, seed: int, sets: Sequence[str] = (), folder: Path | None = None) -> Summary:
    """Run one drive and return its summary; raise RuntimeError where the command itself failed."""
    with tempfile.TemporaryDirectory() as scratch:
        command = [str(GRAPHNAV), "run", graph, "--seed", str(seed), "--no-tap", "--json", "--no-pictures"]
        command += ["-o", str(folder or Path(scratch) / "run")]
        if folder is None:
            command += ["--set", "run.record=small"]
        for swap in sets:
            command += ["--set", swap]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if not done.stdout:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr}")
    summary: Summary = json.loads(done.stdout)
    return summary


def drive_all(graph: str, seeds: Sequence[int], sets: Sequence[str] = (), jobs: int = 2) -> Drives:
    """Run a drive for every seed, ``jobs`` at a time."""
    with ThreadPoolExecutor(jobs) as pool:
        summaries = tuple(pool.map(lambda seed: drive(graph, seed, sets), seeds))
    return Drives(graph, tuple(sets), tuple(seeds), summaries)
