"""``graphnav up`` with ssh on this machine: the same log, lines, how all end together, and every error on the way."""

from __future__ import annotations

import signal
import socket
import sys
from contextlib import closing
from pathlib import Path

import asyncssh
import pytest

from graphnav import UserError
from graphnav.core.cli import main
from graphnav.core.run_folder import RunFolder
from graphnav.processes import ssh
from tests.processes.conftest import PATIENCE_S, wait_until
from tests.processes.over_ssh import DEPLOY, Robot, write

QUIET = ("--no-tap", "--no-pictures")
UP = ("up", *QUIET)


def test_the_log_is_that_of_one_process(robot: Robot) -> None:
    write(robot.folder, "")
    assert robot.said("run", *QUIET, "-o", "alone", "--seed", "7")[0] == 0
    write(robot.folder, DEPLOY)
    status, printed = robot.said(*UP, "-o", "both", "--seed", "7")
    assert status == 0, printed
    logs = [(robot.folder / name / RunFolder.LOG).read_bytes() for name in ("alone", "both")]
    assert logs[0] == logs[1]
    assert f"[jetson] host jetson waits on port {robot.port} for a run that wants eyes" in printed
    assert "[jetson] process 'eyes' for the run at 127.0.0.1" in printed
    assert not list(robot.server.home.rglob("hosts.key")), "the key is written nowhere"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_both(robot: Robot, number: int) -> None:
    hangs = robot.hang()
    up = robot.start(*UP, "-o", "run")
    wait_until(hangs)
    up.send_signal(number)
    _, printed = up.communicate(timeout=PATIENCE_S)
    assert up.returncode == 130, printed


def test_kill_leaves_nothing(robot: Robot) -> None:
    hangs = robot.hang()
    up = robot.start(*UP, "-o", "run", program=(sys.executable, "-m", "graphnav"))
    wait_until(hangs)
    assert robot.is_left()
    up.kill()
    up.communicate(timeout=PATIENCE_S)
    wait_until(lambda: not robot.is_left())


def test_a_lost_connection_ends_both(robot: Robot) -> None:
    hangs = robot.hang()
    up = robot.start(*UP, "-o", "run")
    wait_until(hangs)
    robot.server.cut()
    _, printed = up.communicate(timeout=PATIENCE_S)
    assert up.returncode == 1, printed
    assert "host jetson: the connection of ssh is lost\n  the run ends\n" in printed
    wait_until(lambda: not robot.is_left())


def test_a_host_that_has_another_graph_is_refused(robot: Robot) -> None:
    write(robot.server.home, DEPLOY, first="{what: shut, at: 900}")
    status, printed = robot.said(*UP, "-o", "run")
    assert status == 1
    refused = "it cannot live on the host jetson: it has another graph, or runs it with other options (--set, --plugin)"
    assert refused in printed


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            {"command": "graphnaf"},
            "host jetson: its shell does not find 'graphnaf'\n  write where it is into jetson of hosts.yaml: command: ",
        ),
        (
            {"folder": "nowhere"},
            "[jetson] /bin/sh: 1: cd: can't cd to nowhere\n",
        ),
        (
            {"ssh_port": 1},
            "host jetson, 127.0.0.1, port 1: no ssh server answers: Connection refused\n  start sshd there, or ",
        ),
        ({"address": "jetson.invalid"}, "host jetson, jetson.invalid, port"),
    ],
)
def test_what_is_wrong_with_a_host_is_said(robot: Robot, given: dict[str, object], said: str) -> None:
    robot.write_hosts(**given)
    status, printed = robot.said(*UP, "-o", "run")
    assert status == 2
    assert said in printed
    assert "\nhosts.yaml:1:" in f"\n{printed}"
    assert not (robot.folder / "run").exists()


def test_a_key_that_is_not_known_is_refused(robot: Robot) -> None:
    for key in (None, asyncssh.generate_private_key("ssh-ed25519")):
        robot.server.knows(key)
        status, printed = robot.said(*UP, "-o", "run")
        assert status == 2
        assert "its key is not the one that is known, or none is" in printed
        assert f"connect once by 'ssh -p {robot.server.port} 127.0.0.1', which shows its key and stores it" in printed
    (robot.server.home / ".ssh" / "config").write_text("UserKnownHostsFile none\n")
    status, printed = robot.said(*UP, "-o", "run")
    assert status == 2
    assert "its key" in printed


def test_a_user_who_is_not_let_in_is_told(robot: Robot) -> None:
    robot.server.forgets_the_user()
    status, printed = robot.said(*UP, "-o", "run")
    assert status == 2
    assert "it does not let you in" in printed
    assert f"give it your public key by 'ssh-copy-id -p {robot.server.port} 127.0.0.1'" in printed


def test_an_ssh_server_that_runs_no_commands_is_told(tmp_path: Path) -> None:
    robot = Robot(tmp_path, runs_commands=False)
    with closing(robot.server):
        status, printed = robot.said(*UP, "-o", "run")
    assert status == 2, printed
    assert "host jetson: ssh fails: " in printed
    assert "Traceback" not in printed


def test_a_host_that_serves_already_is_told(robot: Robot) -> None:
    with socket.create_server(("", robot.port)):
        status, printed = robot.said(*UP, "-o", "run")
    assert status == 2
    assert f"[jetson] port {robot.port} cannot be used: Address already in use\n" in printed
    assert "host jetson: its command has ended, by status 2, before it waited for the run" in printed


def test_the_extra_is_named_where_it_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "asyncssh", None)
    with pytest.raises(UserError, match=r"^to reach another host graphnav needs asyncssh\n  pip install '?asyncssh>="):
        ssh.import_asyncssh()


def test_a_graph_without_hosts_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["up", "corridor_ccw"]) == 2
    said = "no process of corridor_ccw lives on another host\n  write deploy: {eyes: {stages: [flow], host: jetson}}"
    assert capsys.readouterr().err == f"{said}, or use 'graphnav run'\n"
