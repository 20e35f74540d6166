"""A signal while a run is made or ends, not while its stages fire, costs nothing of its record."""

from __future__ import annotations

import json
import signal
import subprocess
from pathlib import Path

import pytest

from graphnav import Recording
from tests.forked_commands import forked_graphnav

SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
PLUGIN = """
import os, threading
from graphnav import Finished, Source, Twist, hookimpl, param


class Late(Source):
    when: str = param("", doc="the method that sends the signal")
    number: int = param(0, doc="the signal")
    hangs: bool = param(False, doc="whether the method does not return")

    def __post_init__(self):
        super().__post_init__()
        self.send("init")

    def reset(self, seed):
        self.send("reset")

    def step(self) -> Twist:
        return Twist(1.0, 0.0)

    def summary(self):
        self.send("summary")
        return {}

    def close(self):
        self.send("close")

    def send(self, method):
        if method == self.when:
            os.kill(os.getpid(), self.number)
            if self.hangs:
                threading.Event().wait()


@hookimpl
def graphnav_stages():
    return [Late]
"""


def run(folder: Path, when: str, number: int, *, hangs: bool = False) -> subprocess.CompletedProcess[str]:
    """Run a graph whose stage sends its own process a signal."""
    (folder / "late.py").write_text(PLUGIN)
    options = f"{{when: {when}, number: {int(number)}, hangs: {str(hangs).lower()}}}"
    (folder / "graph.yaml").write_text(f"run: {{until_s: 1}}\nstages:\n  a: {{use: late.late, with: {options}}}\n")
    command = [str(forked_graphnav()), "run", "graph.yaml", "--plugin", "late.py", "--no-tap", "-o", "out"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_before_the_run_ends_it_at_once(tmp_path: Path, number: int) -> None:
    done = run(tmp_path, "init", number)
    assert (done.returncode, done.stderr) in {(130, "stopped\n"), (-number, "")}
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("when", ["summary", "close"])
def test_a_signal_while_a_run_ends_costs_nothing_of_its_record(tmp_path: Path, when: str, number: int) -> None:
    done = run(tmp_path, when, number)
    assert (done.returncode, done.stderr) == (130, "stopped\n")
    assert_recorded(tmp_path / "out", "timeout")


@pytest.mark.parametrize("number", SIGNALS)
def test_a_stage_that_does_not_close_is_broken_off(tmp_path: Path, number: int) -> None:
    done = run(tmp_path, "close", number, hangs=True)
    assert done.returncode == 130
    assert "Traceback" not in done.stderr
    assert_recorded(tmp_path / "out", "stopped")


def assert_recorded(folder: Path, outcome: str) -> None:
    """See that log and summary are complete."""
    assert json.loads((folder / "summary.json").read_text())["outcome"] == outcome
    log = Recording(folder / "run.lcmlog")
    assert (log.truncated, log.count("a.twist")) == (None, 11)
    assert not (folder / "progress").exists()
