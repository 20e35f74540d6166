"""Connections over ssh to the hosts of `hosts.yaml`, with the user's own configuration, keys and known hosts."""

from __future__ import annotations

import asyncio
import os
import shlex
import socket
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from graphnav import UserError, import_extra
from graphnav.processes.hosts import HostKeys

if TYPE_CHECKING:
    from asyncssh import SSHClientConnection

NOT_FOUND = 127
"""Exit status of a shell that does not find a command."""
_CONNECT_S = 30.0
_ALIVE_S, _MAX_SILENCES = 5.0, 6
"""A connection is given up after 30 s of silence, as the other end gives it up: a cable may be out for a while."""


async def connected(name: str, host: HostKeys) -> SSHClientConnection:
    """Connect to a host.

    Raises
    ------
    UserError
        asyncssh is missing, or the host cannot be reached, is not known, or does not let the user in.
    """
    asyncssh = import_asyncssh()
    target = f"{host.user}@{host.address}" if host.user else host.address
    by_hand = f"ssh -p {host.ssh_port} {target}" if host.ssh_port else f"ssh {target}"
    given = {"username": host.user, "port": host.ssh_port}
    options = {
        "host": host.address,
        "config": (),  # the user's
        "keepalive_interval": _ALIVE_S,
        "keepalive_count_max": _MAX_SILENCES,
        **{key: value for key, value in given.items() if value is not None},
    }
    where = f"host {name}, {target}{f', port {host.ssh_port}' if host.ssh_port else ''}"

    def refused(what: str, hint: str) -> UserError:
        return UserError.of(f"{where}: {what}", hint, host.place("address"))

    try:
        if asyncssh.SSHClientConnectionOptions(**options).known_hosts is None:
            raise refused(
                "your ssh configuration turns off the check of its key", "remove UserKnownHostsFile none for it"
            )
        async with asyncio.timeout(_CONNECT_S):
            connection: SSHClientConnection = await asyncssh.connect(**options)
    except socket.gaierror as error:
        what = f"the address is not known: {error.strerror}"
        raise refused(what, "correct the address, or write its IP address") from error
    except TimeoutError as error:
        what = f"no ssh server answers within {_CONNECT_S:g} s"
        raise refused(what, "switch it on, or correct address and ssh_port") from error
    except OSError as error:
        why = os.strerror(error.errno) if error.errno else str(error)
        raise refused(f"no ssh server answers: {why}", "start sshd there, or correct address and ssh_port") from error
    except asyncssh.HostKeyNotVerifiable as error:
        what = f"its key is not the one that is known, or none is: {error.reason}"
        raise refused(what, f"connect once by '{by_hand}', which shows its key and stores it") from error
    except asyncssh.PermissionDenied as error:
        what = f"it does not let you in: {error.reason}"
        raise refused(what, f"give it your public key by '{by_hand.replace('ssh', 'ssh-copy-id', 1)}'") from error
    except (asyncssh.Error, ValueError) as error:
        raise refused(f"ssh fails: {error}", f"try '{by_hand}'") from error
    return connection


def import_asyncssh() -> Any:
    """Return asyncssh.

    Raises
    ------
    UserError
        It is not installed.
    """
    return import_extra("asyncssh", "ssh", "to reach another host graphnav")


def shell_line(host: HostKeys, words: Sequence[str]) -> str:
    """Return what the shell of a host is told to run graphnav."""
    line = f"{host.command} {shlex.join(words)}"
    return f"cd {shlex.quote(host.folder.removeprefix('~/'))} && {line}" if host.folder else line


def not_found(name: str, host: HostKeys) -> UserError:
    """Return the error of a host whose shell does not find graphnav."""
    what = f"host {name}: its shell does not find '{host.command}'"
    hint = f"write where it is into {name} of hosts.yaml: command: /opt/venv/bin/graphnav"
    return UserError.of(what, hint, host.place("command"))
