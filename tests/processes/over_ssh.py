"""An ssh server on this machine for tests: real ssh, real keys, and a shell for each command, as sshd runs it."""

from __future__ import annotations

import asyncio
import json
import os
import socket
import subprocess
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from typing import Any

import asyncssh

from graphnav.processes.hosts import FILE
from tests.forked_commands import forked_graphnav
from tests.processes.conftest import PATIENCE_S, STAGES, STEPS, processes_of

DEPLOY = """deploy:
  eyes: {stages: [first, second], host: jetson}
  hand: {stages: [both]}
"""
GRAPH = "steps.yaml"


class SshServer:
    """A server in a thread, with a host key of its own; ``home``: of the user who may connect, and where commands run.

    A command with ``home`` as HOME knows the host and has the key of the user. ``runs_commands``: as for users who may
    but forward ports, if it does not.
    """

    def __init__(self, home: Path, environment: dict[str, str], *, runs_commands: bool = True) -> None:
        self.home, self._environment, self._runs_commands = home, environment, runs_commands
        self._ssh = home / ".ssh"
        self._ssh.mkdir(mode=0o700)
        user = asyncssh.generate_private_key("ssh-ed25519")
        user.write_private_key(self._ssh / "id_ed25519")
        user.write_public_key(self._ssh / "authorized_keys")
        self._host_key = asyncssh.generate_private_key("ssh-ed25519")
        self._port: Future[int] = Future()
        self._end = asyncio.Event()
        self._loop = asyncio.new_event_loop()
        self._commands: list[asyncio.Task[None]] = []
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()
        self.port = self._port.result()
        self.knows(self._host_key)

    def knows(self, key: asyncssh.SSHKey | None) -> None:
        """Let the user know a key as that of the host, or none."""
        name = f"[127.0.0.1]:{self.port} ".encode()
        (self._ssh / "known_hosts").write_bytes(b"" if key is None else name + key.export_public_key())

    def forgets_the_user(self) -> None:
        """Let the user have another key than the one that is let in."""
        other = asyncssh.generate_private_key("ssh-ed25519")
        other.write_private_key(self._ssh / "id_ed25519")

    def cut(self) -> None:
        """Cut all connections, and take no new ones."""
        with suppress(RuntimeError):  # cut before
            self._loop.call_soon_threadsafe(self._end.set)

    def close(self) -> None:
        """Cut all, and wait for the end of every command."""
        self.cut()
        self._thread.join()

    def _serve(self) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._listen())

    async def _listen(self) -> None:
        connections: list[asyncssh.SSHServerConnection] = []
        listening = await asyncssh.listen(
            "127.0.0.1",
            0,
            server_host_keys=[self._host_key],
            authorized_client_keys=str(self._ssh / "authorized_keys"),
            process_factory=self._begin if self._runs_commands else None,
            acceptor=connections.append,
            encoding=None,
        )
        self._port.set_result(listening.get_port())
        await self._end.wait()
        listening.close()
        for connection in connections:
            connection.abort()
        await asyncio.gather(*(connection.wait_closed() for connection in connections), *self._commands)
        await listening.wait_closed()

    def _begin(self, process: asyncssh.SSHServerProcess[bytes]) -> None:
        self._commands.append(asyncio.create_task(self._run(process)))

    async def _run(self, process: asyncssh.SSHServerProcess[bytes]) -> None:
        environment = os.environ | self._environment | {"HOME": str(self.home)}
        pipe = asyncio.subprocess.PIPE
        shell = await asyncio.create_subprocess_shell(
            process.command or "", cwd=self.home, env=environment, stdin=pipe, stdout=pipe, stderr=pipe
        )
        assert shell.stdin is not None
        told = asyncio.create_task(_copy(process.stdin, shell.stdin))
        await asyncio.gather(_copy(shell.stdout, process.stdout), _copy(shell.stderr, process.stderr))
        status = await shell.wait()
        told.cancel()
        process.exit(status)


async def _copy(source: Any, target: Any) -> None:
    """Copy to the end, or to that of the connection; the target of standard input is closed then."""
    with suppress(OSError, asyncssh.Error):
        while data := await source.read(1 << 16):
            target.write(data)
            await target.drain()
    if isinstance(target, asyncio.StreamWriter):
        target.close()
    else:
        while await source.read(1 << 16):  # the connection is lost: what is printed is of no use to anyone
            pass


def free_port() -> int:
    """Return a port on which nothing listens."""
    with socket.create_server(("127.0.0.1", 0)) as found:
        return int(found.getsockname()[1])


def write(folder: Path, deploy: str, **given: str) -> None:
    """Write the graph into a folder."""
    (folder / GRAPH).write_text(STEPS.format(deploy=deploy, more="", **{"first": "{}", "third": "{}"} | given))


class Robot:
    """A computer that has the graph, and knows the host jetson, which is this machine as well."""

    def __init__(self, folder: Path, *, runs_commands: bool = True) -> None:
        self.folder, self.probe = folder, f"{os.getpid()} {folder.name}"
        (folder / "home").mkdir()
        self.server = SshServer(folder / "home", {"PROBE": self.probe}, runs_commands=runs_commands)
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
        """Start a command for the graph."""
        command = [*(program or (str(forked_graphnav()),)), *words, GRAPH, "--plugin", str(STAGES)]
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
