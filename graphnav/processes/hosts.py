"""The hosts on which stages live: where they are, as ``hosts.yaml`` says, and what they must have alike."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from graphnav import FileFormat, Graph, Record, UserError, did_you_mean, key
from graphnav.core.graph import resolved_yaml
from graphnav.core.spec import RunOptions
from graphnav.processes.host_key import key_file, read_key

FILE = "hosts.yaml"
SERVICE = "host of stages"
"""As `host_link` calls what a host offers."""
DEFAULT_PORT = 7669


class HostKeys(Record):
    """A machine on which processes of a run may live."""

    noun = "a host"
    named = "the host '{}'"
    example = "jetson: {address: 192.168.1.5}"

    address: str = key(not_empty=True, missing="does not say where it is", doc="name or IP address")
    port: int = key(DEFAULT_PORT, ge=1, le=65_535, doc="the TCP port on which it waits for runs")
    user: str | None = key(None, not_empty=True, doc="for `up`: as whom ssh connects; null: as ssh does by itself")
    ssh_port: int | None = key(None, ge=1, le=65_535, doc="for `up`: the port of its ssh server; null: as of ssh, 22")
    command: str = key(
        "graphnav",
        not_empty=True,
        doc="for `up`: how the shell there calls graphnav, such as `/opt/venv/bin/graphnav`",
    )
    folder: str | None = key(
        None, not_empty=True, doc="for `up`: the folder there in which it works, of the user's home; null: the home"
    )


class HostsKeys(Record):
    """The machines that graphs name in `deploy`."""

    noun = "a file of hosts"

    hosts: Mapping[str, HostKeys] = key(min_items=1, doc="by the name that graphs give them", hint="write hosts: {}")


HOSTS = FileFormat(
    "hosts",
    HostsKeys,
    "Hosts",
    """A graph says in `deploy` on which host a process lives; `hosts.yaml`, beside the graph or in the working folder,
says where that is. [Two computers](../howto/two-computers.md) has the rest.

```yaml
hosts:
  jetson: {address: 192.168.1.5, user: robot, command: /opt/venv/bin/graphnav}
```
""",
)


class Host(NamedTuple):
    """Where a host is, and the key that both ends have."""

    name: str
    address: str
    port: int
    key: bytes


def hosts_of(graph: Graph, given: Path | None = None, key_path: Path | None = None) -> dict[str, Host]:
    """Return the hosts that a graph names; ``given``: as of `declared_hosts`, ``key_path``: None for the user's key.

    Raises
    ------
    UserError
        The file is missing or wrong, or does not name a host, or the key is missing.
    """
    found = declared_hosts(graph, given)
    if not found:
        return {}
    link_key = read_key(key_file(key_path))
    return {name: Host(name, host.address, host.port, link_key) for name, host in found.items()}


def declared_hosts(graph: Graph, given: Path | None = None) -> dict[str, HostKeys]:
    """Return what the file says of the hosts that a graph names; ``given``: None for ``hosts.yaml``, beside it or here.

    Raises
    ------
    UserError
        The file is missing or wrong, does not name a host, or gives two of them the same address and port.
    """
    wanted = {part.host: part.name for part in graph.deploy.values() if part.host is not None}
    if not wanted:
        return {}
    file = _file(graph, given)
    if file is None:
        names = ", ".join(f"{name}: {{address: 192.168.1.5}}" for name in wanted)
        what = f"{FILE} is missing, beside the graph and here: it says where {', '.join(wanted)} is"
        raise UserError.of(what, f"write hosts: {{{names}}} into one")
    found = _read(file)
    for name, part in wanted.items():
        if name not in found:
            hint = did_you_mean(name, found) or f"write {name}: {{address: 192.168.1.5}} into it"
            raise UserError.of(f"the process '{part}' lives on the host '{name}', which {file} does not name", hint)
    hosts = {name: found[name] for name in wanted}
    at: dict[tuple[str, int], str] = {}
    for name, host in hosts.items():
        other = at.setdefault((host.address, host.port), name)
        if other != name:
            what = f"the hosts '{other}' and '{name}' are both at {host.address}, port {host.port}"
            raise UserError.of(what, "give each an address or a port of its own", host.place("address"))
    return hosts


def port_of(graph: Graph, name: str, given: Path | None) -> int:
    """Return the port on which a host waits; ``given``: as of `hosts_of`, but there may be no file.

    Raises
    ------
    UserError
        The file is wrong.
    """
    path = _file(graph, given)
    found = {} if path is None else _read(path)
    return found[name].port if name in found else DEFAULT_PORT


def named_here() -> Mapping[str, HostKeys]:
    """Return the hosts of the ``hosts.yaml`` in the working folder, none without one.

    Raises
    ------
    UserError
        The file is wrong.
    """
    path = Path(FILE)
    return _read(path) if path.exists() else {}


def fingerprint(graph: Graph, host: str) -> str:
    """Return what two machines must have alike of a host's processes: all values, with paths as they are written."""
    parts = {name: part for name, part in graph.deploy.items() if part.host == host}
    stages = {stage for part in parts.values() for stage in part.stages}
    nodes = tuple(node for node in graph.nodes if node.name in stages)
    alone = replace(graph, about="", nodes=nodes, deploy=parts, run=RunOptions(), inputs={}, outputs={}, queues={})
    alone = replace(alone, notices=(), file_notices=())
    return hashlib.sha256(resolved_yaml(alone).encode()).hexdigest()


def _file(graph: Graph, given: Path | None) -> Path | None:
    beside = (graph.path.parent / FILE, Path(FILE))
    return given or next((path for path in beside if path.exists()), None)


def _read(path: Path) -> Mapping[str, HostKeys]:
    content, problems = HOSTS.read(path)
    if problems or content is None:
        raise UserError(problems)
    return content.hosts
