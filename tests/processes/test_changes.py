"""A running run is changed: stages take over between two stamps, replays repeat it, what is wrong is refused."""

from __future__ import annotations

import json
import os
import signal
import socket
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from graphnav import Recording
from graphnav.core.cli import main
from graphnav.core.messages import Changed
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import RunningRun
from tests.processes.conftest import PATIENCE_S, STAGES, STEPS, OtherUser, wait_until

GRAPH = STEPS.replace("until_s: 3", "until_s: null").replace("n: 25", "n: 1000000").replace("n: 1000,", "n: 1000000,")
RIGHT = "deploy: {right: {stages: [third]}}"
PARTS = "deploy: {left: {stages: [clock, first, second]}, right: {stages: [third, both, slow]}}"


class Running:
    """A detached run of the stages that count."""

    def __init__(self, folder: Path, words: list[str], third: str, deploy: str) -> None:
        graph, self.folder = folder / "steps.yaml", folder / "run"
        graph.write_text(GRAPH.format(deploy=deploy, first="{}", third=third, more=""))
        given = ["run", str(graph), "--plugin", str(STAGES), "-o", str(self.folder), "--no-tap", "--no-pictures", "-d"]
        subprocess.run([sys.executable, "-m", "graphnav", *given, *words], capture_output=True, check=True)
        self.run = next(run for run in RunningRun.all() if run.folder == self.folder)

    @property
    def summary(self) -> dict[str, Any]:
        """The summary of the run, which has ended."""
        found: dict[str, Any] = json.loads((self.folder / RunFolder.SUMMARY).read_text())
        return found

    def connected(self) -> socket.socket:
        """Return a socket that is connected to the run."""
        path = RunningRun.socket_path(self.run.run_id)
        assert path is not None
        link = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        link.settimeout(PATIENCE_S)
        link.connect(str(path))
        return link

    def goes_on_after(self, changes: int) -> bool:
        """Whether the log holds so many changes, and what a stage made after the last."""
        with Recording(self.folder / RunFolder.LOG) as recording:
            made = [at for at, *_ in recording.messages(Changed.CHANNEL)]
            return len(made) >= changes and max(at for at, *_ in recording.messages("open.sum")) > made[-1]

    def end(self) -> None:
        """Stop the run."""
        assert main(["stop", self.run.run_id]) == 0


Begin = Callable[..., Running]


@pytest.fixture
def begin(tmp_path: Path) -> Iterator[Begin]:
    """Return what begins a run, which is killed at the end."""
    begun = []

    def begin(*words: str, third: str = "{}", deploy: str = "") -> Running:
        begun.append(Running(tmp_path, list(words or ("--pace", "10")), third, deploy))
        return begun[-1]

    yield begin
    for running in begun:
        if running.run.is_running:
            os.kill(running.run.pid, signal.SIGKILL)


def differences(folder: Path, capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Return the last line of what a replay says."""
    capsys.readouterr()
    main(["replay", str(folder), *words])
    out, err = capsys.readouterr()
    return (out.strip() or err).splitlines()[-1]


@pytest.mark.parametrize(
    ("mode", "deploy"),
    [(("--pace", "10"), ""), (("--live",), ""), (("--live",), PARTS)],
    ids=["lockstep", "live", "live-apart"],
)
def test_a_replay_repeats_all_changes(
    begin: Begin, mode: tuple[str, ...], deploy: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    running = begin(*mode, deploy=deploy)
    assert main(["set", "slow.takes_ms=0", "second.takes_ms=0.5"]) == 0
    graph = (running.folder / RunFolder.GRAPH).read_text()
    assert "takes_ms: 0.5" not in graph
    assert main(["swap", "both=steps.pass"]) == 0
    assert main(["swap", "first=steps.both", "--set", "first.in.two=clock"]) == 0
    assert main(["restart", "second", "--run", str(running.folder)]) == 0
    assert main(["swap", "both=steps.both", "--set", "both.in.two=open.sum", "--run", running.run.run_id]) == 0
    told = capsys.readouterr().out
    assert "both: steps.both swapped for steps.pass; defaults: at=0" in told
    assert "both.two: gone with its wire to open.sum" in told
    assert f"run {running.run.run_id}: first=steps.both, first.in.two=clock from " in told
    wait_until(lambda: running.goes_on_after(6))
    running.end()
    assert (running.folder / RunFolder.GRAPH).read_text() == graph
    made = running.summary["changes"]
    assert [(one["stage"], one["use"], one["words"]) for one in made] == [
        ("slow", "steps.add", ["slow.takes_ms=0", "second.takes_ms=0.5"]),
        ("second", "steps.add", ["slow.takes_ms=0", "second.takes_ms=0.5"]),
        ("both", "steps.pass", ["both=steps.pass"]),
        ("first", "steps.both", ["first=steps.both", "first.in.two=clock"]),
        ("second", "steps.add", []),
        ("both", "steps.both", ["both=steps.both", "both.in.two=open.sum"]),
    ]
    with Recording(running.folder / RunFolder.LOG) as recording:
        logged = [(at, one) for at, _, one in recording.messages(Changed.CHANNEL) if isinstance(one, Changed)]
        assert [(at - recording.begin_us) / 1e6 for at, _ in logged] == pytest.approx([o["at_s"] for o in made], abs=1)
    scores = running.summary["scores"]
    assert scores["second"]["steps"] < scores["open"]["steps"], "its state was reset"
    assert differences(running.folder, capsys).startswith("no differences: ")
    assert differences(running.folder, capsys, "-o", str(tmp_path / "again.lcmlog")).startswith("no differences: ")
    assert differences(tmp_path / "again.lcmlog", capsys, "--plugin", str(STAGES)).startswith("no differences: ")
    assert differences(running.folder, capsys, "--from", str(made[2]["at_s"])).startswith("no differences: ")


def test_a_replay_with_other_settings_leaves_the_changes_of_that_stage_out(
    begin: Begin, capsys: pytest.CaptureFixture[str]
) -> None:
    running = begin()
    assert main(["set", "first.at=3"]) == 0
    running.end()
    capsys.readouterr()
    assert main(["replay", str(running.folder), "--set", "first.at=4"]) == 0
    told = "changes of stage 'first' while the run went on are not repeated: --set gives it other settings"
    assert told in " ".join("".join(capsys.readouterr()).split())


REFUSED = (
    (["set", "second.takes_ms=-1"], "second.takes_ms=-1: steps.add: 'takes_ms' is -1, but must be >= 0"),
    (["set", "second.takes=1"], "second.takes=1: steps.add has no parameter 'takes'\n  did you mean 'takes_ms'?"),
    (["set", "secnd.takes_ms=1"], "secnd.takes_ms=1: there is no stage 'secnd'\n  did you mean 'second'?"),
    (["set", "clock.n=3"], "clock.n=3: stage 'clock' (steps.count) is a source: "),
    (
        ["set", "second.deadline_ms=3"],
        "second.deadline_ms=3: 'deadline_ms' is not a parameter: it holds for the entire",
    ),
    (["set", "run.seed=3"], "run.seed=3: this is not what 'graphnav set' changes"),
    (["set", "second=steps.pass"], "second=steps.pass: this is not what 'graphnav set' changes\n  write STAGE."),
    (["swap", "first=steps.pas"], "first=steps.pas: family 'steps' has no stage 'pas'\n  did you mean 'pass'?"),
    (["swap", "third=steps.both"], "third=steps.both: input 'two' of stage 'third' (steps.both) needs Twist, and "),
    (["swap", "first=steps.count"], "first=steps.count: stage 'first' (steps.count) is a source: "),
    (["swap", "second=steps.pass"], "second=steps.pass: input "),
    (["swap", "third=steps.pass", "--set", "open.in.one=clock"], "--set open.in.one=clock: a running graph keeps its"),
    (
        ["swap", "third=steps.pass", "--set", "third.what=fail"],
        "stage 'third' (steps.pass) cannot be reset: ValueError: it fails",
    ),
    (["set", "first.what=fail"], "stage 'first' (steps.pass) cannot be reset: ValueError: it fails"),
    (["restart", "secnd"], "there is no stage 'secnd'\n  did you mean 'second'?"),
    (["restart", "clock"], "stage 'clock' (steps.count) is a source"),
)


def test_what_is_wrong_changes_nothing(begin: Begin, capsys: pytest.CaptureFixture[str]) -> None:
    running = begin(deploy=RIGHT)
    for words, told in REFUSED:
        assert main(words) == 2, words
        assert capsys.readouterr().err.startswith(told), words
    assert main(["set", "first.at=7"]) == 0
    running.end()
    assert [one["words"] for one in running.summary["changes"]] == [["first.at=7"]]
    assert differences(running.folder, capsys).startswith("no differences: ")


def test_a_stage_that_does_not_close_is_told(begin: Begin, capsys: pytest.CaptureFixture[str]) -> None:
    running = begin(third="{what: close, at: 9}")
    assert main(["set", "third.what=nothing"]) == 0
    assert "not closed: stage 'third' (steps.pass) failed at " in capsys.readouterr().out
    running.end()
    assert running.summary["failure"] == ""


def test_two_commands_at_once_both_take_over(begin: Begin, capsys: pytest.CaptureFixture[str]) -> None:
    running = begin(deploy=RIGHT)
    commands = [
        subprocess.Popen([sys.executable, "-m", "graphnav", "set", f"{stage}.at=7"], stdout=subprocess.PIPE, text=True)
        for stage in ("first", "third", "first")
    ]
    assert all(" s on" in command.communicate(timeout=PATIENCE_S)[0] for command in commands)
    running.end()
    made = running.summary["changes"]
    assert sorted(one["stage"] for one in made) == ["first", "first", "third"]
    assert len({one["at_s"] for one in made}) == 3
    assert differences(running.folder, capsys).startswith("no differences: ")


def test_a_command_waits_for_a_step_and_learns_that_the_run_has_ended(begin: Begin, tmp_path: Path) -> None:
    running = begin(third=f"{{what: hang, at: 4, file: {tmp_path / 'hangs'}}}")
    wait_until((tmp_path / "hangs").exists)
    words = [sys.executable, "-m", "graphnav", "set", "first.at=7"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as command:
        assert command.stderr is not None
        assert command.stderr.readline() == "waiting for the run\n"
        running.end()
        assert command.wait(PATIENCE_S) == 1
        assert command.stderr.read() == f"run {running.run.run_id} has ended: nothing was changed\n"


def test_broken_requests_are_refused_and_let_other_requests_through(
    begin: Begin, capsys: pytest.CaptureFixture[str]
) -> None:
    running = begin()
    half = [running.connected() for _ in range(3)]
    for link in half:
        link.sendall(b'{"overrides": ["first')
    for data in (b"", b"\x00\xff" * 99, b"[]", b"[" * 30_000, b'{"overrides": [1], "restart": "", "folder": ""}'):
        with running.connected() as link:
            link.sendall(data)
            link.shutdown(socket.SHUT_WR)
            assert json.loads(link.recv(9999))["problems"][0][1].startswith("the request ")
    with running.connected() as link:
        sent = 0
        try:
            while sent < 1_000_000:
                sent += link.send(b'"' * 10_000)
        except OSError:  # it reads no further
            pass
        assert sent < 1_000_000
    assert main(["set", "first.at=7"]) == 0
    for link in half:
        assert b"not complete within 5 s" in link.recv(9999)
        link.close()
    running.end()
    assert running.summary["failure"] == ""
    assert (running.folder / RunFolder.PRINTED).read_text().count("Traceback") == 0


def test_only_this_user_reaches_a_run(begin: Begin) -> None:
    running = begin()
    path = RunningRun.socket_path(running.run.run_id)
    assert path is not None
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700
    if os.getuid():
        return
    assert OtherUser(path).end() == "PermissionError"
    opened = [path.parent.parent.parent, path.parent.parent, path.parent]
    modes = [folder.stat().st_mode for folder in opened]
    for one in (*opened, path):
        one.chmod(0o777)
    try:
        assert OtherUser(path).end() == "no answer"
    finally:
        for folder, mode in zip(opened, modes, strict=True):
            folder.chmod(mode)
    assert main(["set", "first.at=7"]) == 0


def test_nothing_is_left_of_a_run_that_was_killed(begin: Begin) -> None:
    running = begin()
    path = RunningRun.socket_path(running.run.run_id)
    assert path is not None
    os.kill(running.run.pid, signal.SIGKILL)
    wait_until(lambda: not running.run.is_running)
    assert path.exists()
    assert running.run not in RunningRun.all()
    assert not path.exists()
