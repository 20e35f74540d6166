"""A toy study, run by the command in this process or in one of its own."""

from __future__ import annotations

import csv
import json
import shutil
import subprocess
import sysconfig
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from graphnav.core.cli import main

GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"
TOYS = Path(__file__).parent / "toy_stages.py"
GRAPH = """\
run: {until_s: 5}
stages:
  robot: {use: toy.walker}
  drive: {use: toy.distance, in: {twist: robot}}
"""


class ToyStudy:
    """A study of a toy graph: two variants, four seeds, three of which come to grief with the second."""

    def __init__(self, folder: Path) -> None:
        self.graph = folder / "toy.yaml"
        self.graph.write_text(GRAPH)
        self.plugin = shutil.copy(TOYS, folder / "my_toys.py")
        self.out = folder / "out"

    def words(self, *more: str, vary: str = "robot.odd=fine,contact", seeds: str = "0:4", jobs: int = 2) -> list[str]:
        """Return its command line."""
        words = ["ablate", "toy", "--plugin", str(self.plugin), "--vary", vary, "--seeds", seeds]
        return [*words, "-j", str(jobs), "--gallery", "0", "-o", str(self.out), *more]

    def run(self, *more: str, **options: Any) -> int:
        """Run the command in this process, one run at a time: every process more takes a while to start."""
        return main(self.words(*more, **{"jobs": 1} | options))

    def start(self, *more: str, max_kb: int | None = None, **options: Any) -> subprocess.Popen[str]:
        """Start the command as the leader of a process group, no file of which may have more than ``max_kb``."""
        limit = "unlimited" if max_kb is None else 2 * max_kb
        command = ["sh", "-c", f'ulimit -f {limit}; exec "$@"', "sh", str(GRAPHNAV), *self.words(*more, **options)]
        return subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
        )

    @property
    def rows(self) -> list[dict[str, str]]:
        """The lines of ``results.csv``."""
        with (self.out / "results.csv").open(newline="") as file:
            return list(csv.DictReader(file))

    @property
    def results(self) -> bytes:
        """The bytes of ``results.csv``."""
        return (self.out / "results.csv").read_bytes()

    @property
    def runs(self) -> dict[str, int]:
        """The runs that are there, and when each was made."""
        found = sorted(self.out.glob("runs/*/*/*/summary.json"))
        return {str(path.parent.relative_to(self.out / "runs")): path.stat().st_mtime_ns for path in found}

    def summary(self, run: str) -> dict[str, Any]:
        """Return the summary of a run."""
        found: dict[str, Any] = json.loads((self.out / "runs" / run / "summary.json").read_text())
        return found


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ToyStudy:
    """Return a toy study in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return ToyStudy(tmp_path)


@pytest.fixture
def wait_until() -> Callable[[Callable[[], object]], None]:
    """Return a function that returns once something is so; it is given a minute."""

    def wait(condition: Callable[[], object]) -> None:
        deadline = time.monotonic() + 60
        while not condition():
            assert time.monotonic() < deadline
            time.sleep(0.005)

    return wait
