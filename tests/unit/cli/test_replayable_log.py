"""Commands that read a replayable log say how to make again what it leaves out."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

import graphnav
from graphnav.cli import main

NOTICE = (
    "run/run.lcmlog leaves out large messages that a replay makes again\n"
    "  make the rest again: graphnav replay run -o full.lcmlog\n"
)
Capture = pytest.CaptureFixture[str]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> Callable[[str], None]:
    """Return a function that records a short drive in the folder ``run``, with a ``record`` option."""
    monkeypatch.chdir(tmp_path)

    def record(option: str) -> None:
        words = ["run", "approach", "--until", "1", "--no-tap", "--no-pictures", "--set", f"run.record={option}"]
        assert main([*words, "-o", "run"]) == 0
        capsys.readouterr()

    return record


@pytest.mark.parametrize(
    "words",
    [
        ["figure", "run", "-o", "pictures"],
        ["export", "run", "--to", "csv", "-o", "tables"],
        ["spy", "run", "--once"],
    ],
    ids=lambda words: str(words[0]),
)
def test_a_command_tells_it_last(run: Callable[[str], None], capsys: Capture, words: list[str]) -> None:
    run("replayable")
    assert main(words) == 0
    assert capsys.readouterr().err.endswith(NOTICE)


def test_info_tells_it(run: Callable[[str], None], capsys: Capture) -> None:
    run("replayable")
    hint = "make the rest again: graphnav replay run -o full.lcmlog"
    assert main(["info", "run"]) == 0
    assert f"it leaves out large messages that a replay makes again; {hint}" in capsys.readouterr().out.splitlines()
    assert main(["info", "run", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["completion_hint"] == hint


def test_python_logs_it(run: Callable[[str], None], caplog: pytest.LogCaptureFixture) -> None:
    run("replayable")
    with graphnav.open_log("run") as log:
        assert len(list(log.messages("robot.image"))) == 11
    assert [f"{record.message}\n" for record in caplog.records] == [NOTICE]


def test_the_log_of_the_replay_leaves_nothing_out(run: Callable[[str], None], capsys: Capture) -> None:
    run("replayable")
    assert main(["replay", "run", "-o", "full.lcmlog"]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert "reproduced: robot.truth, by stepping robot with the recorded guard.twist" in said.out.splitlines()
    assert main(["figure", "full.lcmlog", "-o", "pictures"]) == 0
    assert capsys.readouterr().err == ""


def test_other_logs_are_not_told(run: Callable[[str], None], capsys: Capture) -> None:
    run("all")
    assert main(["figure", "run", "-o", "pictures"]) == 0
    assert capsys.readouterr().err == ""
