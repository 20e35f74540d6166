"""The share of a run that one host has: it waits for runs, and starts the processes that they want here."""

from __future__ import annotations

import math
import os
import select
import signal
import time
from collections.abc import Callable, Mapping
from contextlib import closing, suppress
from pathlib import Path, PurePath
from typing import Any

from graphnav import Graph, UserError
from graphnav.core.graph import Part, part_yaml
from graphnav.core.interrupts import Interrupt
from graphnav.core.runner import new_run_id
from graphnav.processes import child
from graphnav.processes.children import Children, Running
from graphnav.processes.frames import Frame, Kind, Link
from graphnav.processes.host_key import key_file, made_key
from graphnav.processes.host_link import HostLink, HostListener, LinkError, Refusal, events_of
from graphnav.processes.host_orders import FROM_STDIN, Orders, waiting
from graphnav.processes.hosts import SERVICE, fingerprint, port_of
from graphnav.processes.output_lines import OutputLines

_LOOK_S = 0.1
_JOIN_S = 5.0
_END_S = 1.0
"""How long a process may take to end that has closed its side of the connection."""


class HostedProcess:
    """A process of this host, from the connection of the run that wants it to its end."""

    def __init__(self, link: HostLink) -> None:
        self.link = link
        self.part: Part | None = None
        """Known when the run has said which one it wants."""
        self.run = ""
        self.joined_s = time.monotonic()
        self.running: Running | None = None
        self.stages: Link | None = None
        """The connection to the process."""
        self.asked: list[Frame] = []
        """Frames of the run from before the process was there."""
        self.refusal = ""
        """Why the run cannot have what it wants."""
        self.killed_s = math.inf
        """When the process is killed, which has closed its side of the connection and has not ended, monotonic s."""


class HostShare:
    """Serves one run after another until it is asked to stop.

    ``name``: of this host. ``notice`` gets what happens, and what stages print.
    """

    def __init__(self, graph: Graph, name: str, listener: HostListener, notice: Callable[[str], None]) -> None:
        self._graph, self._name, self._listener, self._notice = graph, name, listener, notice
        self._parts = {part.name: part for part in graph.deploy.values() if part.host == name}
        self._same = fingerprint(graph, name)
        self._children = Children(new_run_id(), len(self._parts))
        self._hosted: list[HostedProcess] = []
        self._n_started = 0

    def serve(self, is_asked_to_stop: Callable[[], bool]) -> None:
        """Serve until it is asked to stop."""
        while not is_asked_to_stop():
            ready = self._ready()
            for link in self._listener.step(ready, len(self._hosted)):
                self._hosted.append(HostedProcess(link))
            if self._children.listener.fileno() in ready:
                self._accept()
            for one in tuple(self._hosted):
                if one in self._hosted:  # not dropped since, for another one
                    self._go_on(one, ready)

    def close(self) -> None:
        """End all processes."""
        for one in tuple(self._hosted):
            self._drop(one)
        self._children.close()
        self._listener.close()

    def _ready(self) -> dict[int, int]:
        poll = select.poll()
        poll.register(self._children.listener, select.POLLIN)
        for fd, events in self._listener.pollables():
            poll.register(fd, events)
        for one in self._hosted:
            poll.register(one.link.fileno(), events_of(one.link))
            if one.running is not None:
                poll.register(one.running.pid_fd, select.POLLIN)
            if one.stages is not None:
                is_reading = not one.link.is_sending
                poll.register(one.stages.fileno(), select.POLLIN * is_reading | select.POLLOUT * one.stages.is_sending)
        return dict(poll.poll(_LOOK_S * 1e3))

    def _accept(self) -> None:
        """Take the connection of a process that was started."""
        hosted = [one for one in self._hosted if one.stages is None and one.killed_s == math.inf]
        waiting = {one.running.popen.pid: one for one in hosted if one.running is not None}
        found = self._children.accept(waiting.keys())
        if found is not None:
            one = waiting[found[0]]
            one.stages = Link(found[1])
            for frame in one.asked:
                self._tell(one, frame)
            one.asked.clear()

    def _go_on(self, one: HostedProcess, ready: Mapping[int, int]) -> None:
        """Pass on what a run and its process say."""
        try:
            one.link.tick(time.monotonic())
            if one.link.fileno() in ready:
                one.link.send_more()
                while (frame := one.link.receive()) is not None:
                    self._take(one, frame)
            self._hear(one, ready)
        except LinkError as error:
            self._drop(one, str(error) if one.part is not None else "")
        if one.part is None and time.monotonic() - one.joined_s > _JOIN_S and one in self._hosted:
            self._drop(one)
        if time.monotonic() > one.killed_s and one.running is not None:
            one.running.popen.kill()

    def _hear(self, one: HostedProcess, ready: Mapping[int, int]) -> None:
        """Pass on what a process says, and its end."""
        stages, running = one.stages, one.running
        if running is not None and running.pid_fd in ready:
            self._note_end(one, running)
        elif stages is not None and stages.fileno() in ready:
            try:
                stages.send_more()
                while (answer := stages.receive()) is not None:
                    one.link.send(answer)
            except (EOFError, OSError):
                stages.close()
                one.stages, one.killed_s = None, time.monotonic() + _END_S

    def _note_end(self, one: HostedProcess, running: Running) -> None:
        """Tell the run that its process has ended, after what it has said."""
        if one.stages is not None:
            with suppress(EOFError, OSError):
                while (answer := one.stages.receive()) is not None:
                    one.link.send(answer)
        one.running = None
        status = self._children.reap(running)
        one.link.send(Frame(Kind.ENDED, status))
        self._drop(one)

    def _take(self, one: HostedProcess, frame: Frame) -> None:
        """Do what a run says, or let its process do it."""
        if one.refusal:
            one.link.send(Frame(Kind.ANSWER, one.refusal))
        elif one.part is None:
            self._join(one, frame)
        elif frame.kind == Kind.INTERRUPT:
            if one.running is not None:
                one.running.popen.send_signal(signal.SIGINT)
        elif frame.kind == Kind.SETUP and one.running is None:
            self._start(one, one.part, frame)
        elif one.running is not None:
            self._tell(one, frame)

    def _tell(self, one: HostedProcess, frame: Frame) -> None:
        if one.stages is None:
            if one.killed_s == math.inf:
                one.asked.append(frame)
            return
        with suppress(OSError):  # it has ended, which its descriptor tells
            one.stages.send(frame)

    def _join(self, one: HostedProcess, frame: Frame) -> None:
        """Learn which process a run wants, and whether it can have it."""
        head = frame.head if isinstance(frame.head, dict) else {}
        if frame.kind != Kind.JOIN:
            raise LinkError(f"{one.link.peer} does not say what it wants", Refusal.FOREIGN)
        one.run = str(head.get("run"))
        part = self._parts.get(str(head.get("part")))
        other = next((other for other in self._hosted if other.part is not None and other.part == part), None)
        why = ""
        if head.get("host") != self._name:
            why = f"there is the host {self._name}"
        elif part is None or head.get("graph") != self._same:
            why = "it has another graph, or runs it with other options (--set, --plugin)"
        elif other is not None and other.run != one.run:
            why = "it serves another run"
        if why or part is None:
            one.refusal = f"it cannot live on the host {head.get('host')}: {why}"
            return
        if other is not None:
            self._drop(other, "its run has called again")
        one.part = part
        self._notice(f"process '{part.name}' for the run at {one.link.peer}")

    def _start(self, one: HostedProcess, part: Part, frame: Frame) -> None:
        """Start the process that a run wants, with the stages as this host has them."""
        try:
            setup = self._setup(part, frame.head)
        except (KeyError, TypeError, ValueError) as error:  # of another version
            raise LinkError(f"{one.link.peer} does not say what it wants", Refusal.FOREIGN) from error
        self._n_started += 1
        try:
            one.running = self._children.start(
                f"{part.name}/{self._n_started}",
                child.__name__,
                lambda stream: OutputLines(part.name, stream, None, self._notice),
            )
        except OSError as error:
            why = f"its process '{part.name}' cannot be started: {error.strerror or error}"
            one.link.send(Frame(Kind.ANSWER, why))
            return
        self._tell(one, Frame(Kind.SETUP, setup))

    def _setup(self, part: Part, given: Mapping[str, Any]) -> dict[str, Any]:
        """Return what a process is told of its stages, with the paths of this host in place of those of the run."""
        own = {path.name: str(path) for path in self._graph.plugins}
        names = {path: own.get(PurePath(path).name, path) for path in given["plugins"]}
        return {
            **given,
            "path": str(self._graph.path),
            "plugins": [str(path) for path in self._graph.plugins],
            "graph": part_yaml(self._graph, part.stages),
            "versions": {names.get(name, name): version for name, version in given["versions"].items()},
        }

    def _drop(self, one: HostedProcess, why: str = "") -> None:
        """End a process and the connection for it; ``why`` is told."""
        self._hosted.remove(one)
        one.link.close()
        if one.stages is not None:
            one.stages.close()
        if one.running is not None:
            self._children.reap(one.running)
        if one.part is not None:
            self._notice(f"process '{one.part.name}' has ended{f': {why}' if why else ''}")


def serve_host(
    graph: Graph,
    name: str,
    hosts: Path | None,
    key: Path | None,
    notice: Callable[[str], None],
    tell: Callable[[str], None],
) -> None:
    """Serve runs that want processes of ``graph`` on the host ``name``, which is this machine, until Ctrl-C.

    ``hosts``: the file that says on which port, None for ``hosts.yaml`` if there is one. ``key``: the file of the key
    that both ends have, None for the user's; it is made where there is none. `FROM_STDIN`: port and key are `Orders`,
    with which this ends, too, and ``tell`` gets the line of one that waits.

    Raises
    ------
    UserError
        No process of the graph lives on the host, the file or the key cannot be read, no orders come, or the port is
        not free.
    GraphnavError
        The socket for the processes cannot be made.
    """
    parts = [part.name for part in graph.deploy.values() if part.host == name]
    if not parts:
        others = sorted({part.host for part in graph.deploy.values() if part.host is not None})
        hint = (
            f"its hosts are {', '.join(others)}" if others else "write deploy: {eyes: {stages: [flow], host: jetson}}"
        )
        raise UserError.of(f"no process of {graph.path.stem} lives on the host '{name}'", hint)
    orders = Orders() if key == FROM_STDIN else None
    if orders is not None:
        port, found = orders.port, orders.key
    else:
        port, path = port_of(graph, name, hosts), key_file(key)
        found, is_new = made_key(path)
        if is_new:
            notice(f"a new key is in {path}: copy it to the machine of the run, to the same place, with mode 0600")
    try:
        listener = HostListener("", port, found, SERVICE, 2 * len(parts))
    except OSError as error:
        hint = "end what listens there, or write another port into hosts.yaml on both machines"
        why = os.strerror(error.errno) if error.errno else str(error)
        raise UserError.of(f"port {port} cannot be used: {why}", hint) from error
    with Interrupt() as interrupt, closing(HostShare(graph, name, listener, notice)) as share:
        notice(f"host {name} waits on port {port} for a run that wants {', '.join(parts)}")
        if orders is not None:
            tell(waiting(port))
        share.serve(lambda: interrupt.asked or (orders is not None and orders.are_over()))
        interrupt.settle()
