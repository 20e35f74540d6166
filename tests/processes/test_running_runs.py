"""A run that is left behind is listed, read and stopped; one that was killed is forgotten."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphnav.core.cli import main
from graphnav.core.runner import RunningFile, RunningRun
from tests.processes.conftest import STAGES, STEPS, wait_until

GRAPH = STEPS.format(
    deploy="deploy: {right: {stages: [third]}}", first="{}", third="{at: 3, what: print}", more=""
).replace("until_s: 3", "until_s: null")


@pytest.fixture
def left_behind(tmp_path: Path) -> Iterator[Path]:
    """Return the folder of a detached run that has printed something; it is killed at the end."""
    graph, folder = tmp_path / "steps.yaml", tmp_path / "run"
    graph.write_text(GRAPH.replace("n: 25", "n: 1000000"))
    words = ["run", str(graph), "--plugin", str(STAGES), "-o", str(folder), "--no-tap", "--no-pictures", "-d"]
    done = subprocess.run([sys.executable, "-m", "graphnav", *words], capture_output=True, text=True, check=True)
    run = next(run for run in RunningRun.all() if run.folder == folder)
    assert f"run {run.run_id} in {folder}" in done.stdout
    wait_until(lambda: "step 3" in (folder / "printed.txt").read_text())
    yield folder
    if run.is_running:
        os.kill(run.pid, signal.SIGKILL)


def test_a_detached_run_is_listed_read_and_stopped(left_behind: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ps", "--json"]) == 0
    told = next(run for run in json.loads(capsys.readouterr().out) if run["folder"] == str(left_behind))
    assert [(process["name"], process["restarts"]) for process in told["processes"]] == [("right", 0)]
    assert main(["ps"]) == 0
    assert told["run"] in capsys.readouterr().out
    assert main(["logs", told["run"]]) == 0
    assert capsys.readouterr().out == "[right] step 3\\x1b[2J\n"
    follow = subprocess.Popen([sys.executable, "-m", "graphnav", "logs", "-f", str(left_behind)], stdout=-1, text=True)
    assert follow.stdout is not None
    assert follow.stdout.readline() == "[right] step 3\\x1b[2J\n"
    assert main(["stop", told["run"]]) == 0
    assert capsys.readouterr().out == f"run {told['run']} has ended: {left_behind}\n"
    assert "stopped after" in follow.communicate(timeout=60)[0]
    assert json.loads((left_behind / "summary.json").read_text())["outcome"] == "stopped"


def test_a_run_that_is_killed_is_forgotten(left_behind: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stop", str(left_behind), "--hard"]) == 0
    assert not [run for run in RunningRun.all() if run.folder == left_behind]
    assert main(["logs", str(left_behind)]) == 0
    assert "step 3" in capsys.readouterr().out


def test_a_run_is_noted_while_it_lasts(tmp_path: Path) -> None:
    with RunningFile("0123abcd", "steps", tmp_path, is_live=False):
        (run,) = [run for run in RunningRun.all() if run.run_id == "0123abcd"]
        assert (run.pid, run.folder, run.graph, run.is_live) == (os.getpid(), tmp_path, "steps", False)
        assert run.is_running
    assert not run.is_running


def test_a_run_that_begins_is_listed_while_others_list_all_the_time(tmp_path: Path) -> None:
    """A file that is not locked yet is not there yet."""
    ended = threading.Event()

    def listing() -> None:
        while not ended.is_set():
            RunningRun.all()

    readers = [threading.Thread(target=listing) for _ in range(2)]
    for reader in readers:
        reader.start()
    try:
        listed = []
        for k in range(200):
            with RunningFile(f"{k:08x}", "steps", tmp_path, is_live=False):
                listed.append(any(run.run_id == f"{k:08x}" for run in RunningRun.all()))
    finally:
        ended.set()
        for reader in readers:
            reader.join()
    assert all(listed)


def test_what_is_not_running_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with RunningFile("01234567", "steps", Path.cwd(), is_live=False):
        assert main(["stop", "01234568"]) == 2
    assert capsys.readouterr().err == "no run '01234568' is running\n  did you mean '01234567'?\n"


def test_a_fifo_in_place_of_what_was_printed_blocks_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / "printed.txt")
    assert main(["logs", str(tmp_path)]) == 1
    assert "it is a FIFO, not a regular file" in capsys.readouterr().err
