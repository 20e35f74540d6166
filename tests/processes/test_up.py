"""``graphnav up`` with ssh on this machine: the same log, lines, how all end together, and every error on the way."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from graphnav.core.run_folder import RunFolder
from graphnav.processes.hosts import FILE
from tests.forked_commands import forked_graphnav
from tests.processes.conftest import PATIENCE_S, STAGES, STEPS, processes_of, wait_until

asyncssh = pytest.importorskip("asyncssh")

DEPLOY = """deploy:
  eyes: {stages: [first, second], host: jetson}
  hand: {stages: [both]}
"""
GRAPH = "steps.yaml"
TOLD = ("--plugin", str(STAGES), "--no-tap", "--no-pictures")


def free_port() -> int:
    """Return a port on which nothing listens."""
    with socket.create_server(("127.0.0.1", 0)) as found:
        return int(found.getsockname()[1])


def write(folder: Path, deploy: str, **given: str) -> None:
    """Write the graph into a folder."""
    (folder / GRAPH).write_text(STEPS.format(deploy=deploy, more="", **{"first": "{}", "third": "{}"} | given))


class Robot:
    """A computer that has the graph, and knows the host jetson, which is this machine as well."""

    def __init__(self, folder: Path) -> None:
        from tests.processes.ssh_server import SshServer

        self.folder, self.probe = folder, f"{os.getpid()} {folder.name}"
        (folder / "home").mkdir()
        self.server = SshServer(folder / "home", {"PROBE": self.probe})
        self.port = free_port()
        write(folder, DEPLOY)
        write(folder / "home", DEPLOY)
        self.write_hosts()

    def write_hosts(self, **given: object) -> None:
        """Write where the host is; ``given`` changes its keys."""
        said = {"address": "127.0.0.1", "port": self.port, "ssh_port": self.server.port} | given
        said = {"command": str(forked_graphnav())} | said
        (self.folder / FILE).write_text(json.dumps({"hosts": {"jetson": said}}))

    def start(self, *words: str, program: tuple[str, ...] = ()) -> subprocess.Popen[str]:
        """Start a command."""
        command = [*(program or (str(forked_graphnav()),)), *words, GRAPH, *TOLD]
        environment = os.environ | {"HOME": str(self.server.home)}
        pipe = subprocess.PIPE
        return subprocess.Popen(command, cwd=self.folder, env=environment, stdout=pipe, stderr=pipe, text=True)

    def said(self, *words: str) -> tuple[int, str]:
        """Run a command; return its status and what it printed to standard error."""
        done = self.start(*words)
        _, printed = done.communicate(timeout=PATIENCE_S)
        return done.returncode, printed

    def hang(self) -> Callable[[], bool]:
        """Let a stage on the host hang in a step; return what says whether it does."""
        file = self.folder / "hangs"
        for folder in (self.folder, self.server.home):
            write(folder, DEPLOY, first=f"{{at: 3, what: hang, file: {file}}}")
        return lambda: file.exists() and bool(file.read_text())

    def is_left(self) -> bool:
        """Whether something that was started on the host is alive."""
        return bool(processes_of(self.probe))


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    """Return a robot with a host."""
    made = Robot(tmp_path)
    yield made
    made.server.cut()
    wait_until(lambda: not made.is_left())
    made.server.close()


def test_the_log_is_that_of_one_process(robot: Robot) -> None:
    write(robot.folder, "")
    assert robot.said("run", "-o", "alone", "--seed", "7")[0] == 0
    write(robot.folder, DEPLOY)
    status, printed = robot.said("up", "-o", "both", "--seed", "7")
    assert status == 0, printed
    logs = [(robot.folder / name / RunFolder.LOG).read_bytes() for name in ("alone", "both")]
    assert logs[0] == logs[1]
    assert f"[jetson] host jetson waits on port {robot.port} for a run that wants eyes" in printed
    assert "[jetson] process 'eyes' for the run at 127.0.0.1" in printed
    assert not list(robot.server.home.rglob("hosts.key")), "the key is written nowhere"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_both(robot: Robot, number: int) -> None:
    hangs = robot.hang()
    up = robot.start("up", "-o", "run")
    wait_until(hangs)
    up.send_signal(number)
    _, printed = up.communicate(timeout=PATIENCE_S)
    assert up.returncode == 130, printed
    assert not robot.is_left()
    assert "[jetson] process 'eyes' has ended" in printed


def test_kill_leaves_nothing(robot: Robot) -> None:
    hangs = robot.hang()
    up = robot.start("up", "-o", "run", program=(sys.executable, "-m", "graphnav"))
    wait_until(hangs)
    assert robot.is_left()
    up.kill()
    up.communicate(timeout=PATIENCE_S)
    wait_until(lambda: not robot.is_left())


def test_a_lost_connection_ends_both(robot: Robot) -> None:
    hangs = robot.hang()
    up = robot.start("up", "-o", "run")
    wait_until(hangs)
    robot.server.cut()
    _, printed = up.communicate(timeout=PATIENCE_S)
    assert up.returncode == 1, printed
    assert "host jetson: the connection of ssh is lost\n  the run ends\n" in printed
    wait_until(lambda: not robot.is_left())


def test_a_host_that_has_another_graph_is_refused(robot: Robot) -> None:
    write(robot.server.home, DEPLOY, first="{what: shut, at: 900}")
    status, printed = robot.said("up", "-o", "run")
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
    status, printed = robot.said("up", "-o", "run")
    assert status == 2
    assert said in printed
    assert "\nhosts.yaml:1:" in f"\n{printed}"
    assert not (robot.folder / "run").exists()


def test_a_key_that_is_not_known_is_refused(robot: Robot) -> None:
    for key in (None, asyncssh.generate_private_key("ssh-ed25519")):
        robot.server.knows(key)
        status, printed = robot.said("up", "-o", "run")
        assert status == 2
        assert "its key is not the one that is known, or none is" in printed
        assert f"connect once by 'ssh -p {robot.server.port} 127.0.0.1', which shows its key and stores it" in printed
    (robot.server.home / ".ssh" / "config").write_text("UserKnownHostsFile none\n")
    status, printed = robot.said("up", "-o", "run")
    assert status == 2
    assert "its key" in printed


def test_a_user_who_is_not_let_in_is_told(robot: Robot) -> None:
    robot.server.forgets_the_user()
    status, printed = robot.said("up", "-o", "run")
    assert status == 2
    assert "it does not let you in" in printed
    assert f"give it your public key by 'ssh-copy-id -p {robot.server.port} 127.0.0.1'" in printed


def test_a_host_that_serves_already_is_told(robot: Robot) -> None:
    with socket.create_server(("", robot.port)):
        status, printed = robot.said("up", "-o", "run")
    assert status == 2
    assert f"[jetson] port {robot.port} cannot be used: Address already in use\n" in printed
    assert "host jetson: its command has ended, by status 2, before it waited for the run" in printed
