"""Checks of a host that a graph names: from here, over ssh, and by the start of its processes as a run starts them."""

from __future__ import annotations

import asyncio
import json
import socket
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import graphnav
from graphnav import Graph, GraphnavError, UserError
from graphnav.core.machine import offset_text
from graphnav.processes import ssh
from graphnav.processes.hosts import Host, HostKeys
from graphnav.processes.started_hosts import StartedHosts
from graphnav.processes.supervisor import Supervisor

if TYPE_CHECKING:
    from asyncssh import SSHClientConnection, SSHCompletedProcess

_CONNECT_S = 5.0
_READY_S = 60.0
"""How long the stages of a host may take to be made."""
_COMMAND_S = 120.0


class Check(NamedTuple):
    """The result of a check, as the doctor reports it."""

    subject: str
    fine: bool
    seen: str
    fix: str = ""
    needed: bool = True


def host_checks(
    graph: Graph, name: str, host: HostKeys, words: Sequence[str], options: Sequence[str] = ()
) -> Iterator[Check]:
    """Yield the checks of a host, in the order in which they depend on each other; the first fault may be the last.

    ``words``: for commands there, as of `words_for_hosts`; ``options``: more of the doctor there.
    """
    failures = ssh.import_asyncssh().Error
    with asyncio.Runner() as runner:
        address = _address(name, host)
        yield address
        if not address.fine:
            return
        begin_s = time.monotonic()
        try:
            connection = runner.run(ssh.connected(name, host))
        except UserError as error:
            yield _failed(f"{name}: ssh", error)
            return
        yield Check(f"{name}: ssh", fine=True, seen=f"connected in {time.monotonic() - begin_s:.2f} s")
        try:
            yield runner.run(_clock(name, connection))
            version = runner.run(_version(name, host, connection))
            yield version
            if version.fine:
                yield from _processes(graph, name, host, words)
                yield from runner.run(_doctor(name, host, connection, [*words, *options]))
        except failures as error:
            yield Check(f"{name}: ssh", fine=False, seen=f"it fails: {error}", fix="try again")
        finally:
            runner.run(_close(connection))


async def _close(connection: SSHClientConnection) -> None:
    connection.close()
    await connection.wait_closed()


def _address(name: str, host: HostKeys) -> Check:
    subject = f"{name}: address"
    try:
        found = socket.getaddrinfo(host.address, host.port, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError) as error:
        fix = f"write its IP address into {host.place('address')}"
        return Check(subject, fine=False, seen=f"{host.address} is not known: {error}", fix=fix)
    return Check(subject, fine=True, seen=", ".join(dict.fromkeys(str(one[4][0]) for one in found)))


def _failed(subject: str, error: GraphnavError) -> Check:
    """Return the check that ended with an error."""
    if isinstance(error, UserError):
        problem = error.problems[0]
        return Check(subject, fine=False, seen=problem.what, fix=str(problem.hint))
    return Check(subject, fine=False, seen=str(error))


async def _said(connection: SSHClientConnection, line: str) -> SSHCompletedProcess:
    return await connection.run(line, errors="replace", stdin=asyncio.subprocess.DEVNULL, timeout=_COMMAND_S)


async def _clock(name: str, connection: SSHClientConnection) -> Check:
    begin_s, begun = time.monotonic(), time.time()
    said = str((await _said(connection, "date +%s.%N")).stdout)
    took_s = time.monotonic() - begin_s
    subject = f"{name}: clock"
    try:
        ahead_s = float(said) - begun - took_s / 2
    except ValueError:
        return Check(subject, fine=True, seen="not compared: its date tells no fractions of a second")
    return Check(subject, fine=True, seen=f"{offset_text(ahead_s, took_s / 2)}; runs use the one here alone")


async def _version(name: str, host: HostKeys, connection: SSHClientConnection) -> Check:
    said = await _said(connection, ssh.shell_line(host, ["--version"]))
    subject = f"{name}: graphnav"
    if said.exit_status == ssh.NOT_FOUND:
        return _failed(subject, ssh.not_found(name, host))
    lines = (str(said.stdout) + str(said.stderr)).strip().splitlines()
    version, here = str(said.stdout).strip().removeprefix("graphnav "), graphnav.__version__
    if said.exit_status or version != here:
        seen = lines[-1] if lines else f"it ends by status {said.exit_status}"
        return Check(subject, fine=False, seen=f"{seen}, but {here} is here", fix="install the same version on both")
    return Check(subject, fine=True, seen=f"version {version}, as here")


def _processes(graph: Graph, name: str, host: HostKeys, words: Sequence[str]) -> Iterator[Check]:
    """Start the host's command and its processes as a run does, and end them."""
    subject = f"{name}: port {host.port}"
    lines: list[str] = []
    try:
        with StartedHosts({name: host}, ["run", *words], lines.append) as hosts:
            port = _port(subject, host)
            yield port
            if port.fine:
                yield from _stages(graph, name, hosts[name], lines)
    except GraphnavError as error:
        failed = _failed(subject, error)
        yield failed._replace(
            seen="; ".join([*lines, failed.seen]), fix=failed.fix if not lines else "see what it says"
        )


def _port(subject: str, host: HostKeys) -> Check:
    try:
        socket.create_connection((host.address, host.port), _CONNECT_S).close()
    except OSError as error:
        seen = f"it waits there for runs, but cannot be reached from here: {error.strerror or error}"
        fix = f"let TCP port {host.port} pass the firewall there, or write another port into hosts.yaml"
        return Check(subject, fine=False, seen=seen, fix=fix)
    return Check(subject, fine=True, seen="it waits there for runs, and is reached from here")


def _stages(graph: Graph, name: str, host: Host, lines: list[str]) -> Iterator[Check]:
    """Let the host make its stages; it refuses another graph, and other code of them."""
    parts = {key: part for key, part in graph.deploy.items() if part.host == name}
    alone = replace(graph, deploy=parts)
    with (
        tempfile.TemporaryDirectory() as folder,
        closing(Supervisor(alone, Path(folder), lines.append, is_live=True, hosts={name: host})) as supervisor,
    ):
        supervisor.start()
        end_s = time.monotonic() + _READY_S
        while not all(one.is_made or one.is_down for one in supervisor.processes.values()):
            supervisor.wait()
            if time.monotonic() > end_s:
                break
        for part, process in supervisor.processes.items():
            subject = f"{name}: process {part}"
            if process.is_made:
                yield Check(subject, fine=True, seen="its stages are made there, of the same graph and the same code")
            else:
                seen = process.failure or f"its stages are not made within {_READY_S:g} s"
                yield Check(subject, fine=False, seen=seen, fix=process.hint or "copy graph and plugins to the host")


async def _doctor(name: str, host: HostKeys, connection: SSHClientConnection, words: Sequence[str]) -> list[Check]:
    """Return what the doctor says there."""
    said = await _said(connection, ssh.shell_line(host, ["doctor", "--json", *words]))
    try:
        found: list[dict[str, Any]] = json.loads(str(said.stdout))
        return [Check(**{**one, "subject": f"{name}: {one['subject']}"}) for one in found]
    except (ValueError, TypeError, KeyError):
        lines = str(said.stderr).strip().splitlines() or [f"it ends by status {said.exit_status}"]
        return [Check(f"{name}: doctor", fine=False, seen="; ".join(lines), fix="run 'graphnav doctor' there")]
