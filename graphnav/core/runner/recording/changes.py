"""Change a run while it lasts: a socket takes requests, the thread that fires lets new stages take over."""

from __future__ import annotations

import json
import os
import socket
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, Protocol, Self

from graphnav.core.catalog import Catalog
from graphnav.core.codec import encode
from graphnav.core.errors import Place, Problem, StageError, UserError, fix_the_plugin, one_line
from graphnav.core.graph import Graph, GraphChange, Node, Override, changed_graph, part_yaml, restarted_graph
from graphnav.core.graph.node import SET
from graphnav.core.interrupts import CtrlC, third_party_code
from graphnav.core.machine.files import is_own
from graphnav.core.machine.peer import peer_of
from graphnav.core.machine.system import is_linux
from graphnav.core.messages import Changed
from graphnav.core.runner.engine import Engine, seed_of
from graphnav.core.runner.recording.running_file import RunningRun
from graphnav.core.stage import Stage

_MAX_BYTES = 65_536
"""The largest request."""
_MAX_REQUESTS = 8
"""The maximum number of requests that are read, checked, or wait for their turn, at a time."""
_PATIENCE_S = 5.0
"""A request that is not complete after this is refused."""
_BUSY_S = 0.5
"""So long a change waits for a moment in which no stage could fire, so that stages before and behind it have seen the
same stamps."""
_SWITCH_S = 2e-4
_END_S = 1.0
"""How long the end of the run waits for the answers to be sent."""


class Request(NamedTuple):
    """A request to a run: ``overrides`` as ``--set`` takes them, or a ``restart`` of a stage."""

    overrides: tuple[str, ...]
    """Each as it was typed, with the option before it, if any."""
    restart: str
    folder: str
    """Where paths are looked for."""

    @staticmethod
    def parse(data: bytes) -> Request:
        """Return what the bytes ask for; raises UserError if they ask for nothing."""
        try:
            said = json.loads(data)
            request = Request(tuple(said["overrides"]), said["restart"], said["folder"])
        except (ValueError, TypeError, KeyError, RecursionError):
            raise UserError.of("the request cannot be read", "use this version of graphnav for both") from None
        if not all(isinstance(word, str) for word in (*request.overrides, request.restart, request.folder)):
            raise UserError.of("the request does not consist of strings", "use this version of graphnav for both")
        if not (request.overrides or request.restart) or "\0" in request.folder:
            raise UserError.of("the request asks for nothing")
        return request

    def change(self, graph: Graph, began: Graph, catalog: Catalog) -> GraphChange:
        """Return the change of a running graph; raises UserError if it cannot be made."""
        if self.restart:
            return restarted_graph(graph, self.restart)
        problems: list[Problem] = []
        overrides = []
        for words in self.overrides:
            try:
                override = Override.parse(words.removeprefix(f"{SET} "), Place(words))
                overrides.append(replace(override, folder=Path(self.folder)))
            except UserError as error:
                problems += error.problems
        if problems:
            raise UserError(problems)
        return changed_graph(graph, began, overrides, catalog)


class Answer(NamedTuple):
    """The answer to a request: when it took over, or why not."""

    at_s: float | None = None
    """Seconds from the start of the run; None if it did not take over."""
    notices: tuple[str, ...] = ()
    problems: tuple[Problem, ...] = ()
    """Errors of the request; without any the run has ended before."""

    def encoded(self) -> bytes:
        """Return it as bytes."""
        told = [(problem.place, problem.what, str(problem.hint), problem.kind) for problem in self.problems]
        return json.dumps({"at_s": self.at_s, "notices": self.notices, "problems": told}).encode()

    @staticmethod
    def parse(data: bytes) -> Answer:
        """Return what the bytes say; bytes that are not complete say that the run has ended."""
        try:
            said = json.loads(data)
        except ValueError:
            return Answer()
        problems = (
            Problem(None if place is None else Place(*place), what, hint, kind)
            for place, what, hint, kind in said["problems"]
        )
        return Answer(said["at_s"], tuple(said["notices"]), tuple(problems))


def ask(run: RunningRun, request: Request, on_wait: Callable[[], None] = lambda: None) -> Answer:
    """Ask a run for a change, and wait until it has taken over or is refused.

    ``on_wait`` is called if that takes long: the run may be within a step.

    Raises
    ------
    UserError
        The run takes no changes.
    """
    path = RunningRun.socket_path(run.run_id)
    if not run.takes_changes or path is None:
        raise UserError.of(f"run {run.run_id} takes no changes", "those that 'graphnav run' has started do")
    with closing(socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)) as link:
        try:
            _in_folder(path, link.connect)
            with suppress(OSError):  # it does not read all of it, but answers
                link.sendall(json.dumps(request._asdict()).encode())
                link.shutdown(socket.SHUT_WR)
            return Answer.parse(_answer(link, on_wait))
        except OSError:
            return Answer()


class Running(Protocol):
    """The schedule of a run, as far as a change concerns it."""

    graph: Graph

    @property
    def engine(self) -> Engine[Any]:
        """The stages."""

    def hold(self, stages: Collection[str]) -> bool:
        """Begin no step of these stages until the next change; return whether they make none at the moment."""

    def change(self, graph: Graph, nodes: Iterable[Node], stages: Mapping[str, Stage]) -> list[StageError]:
        """Let other stages take over; return what those of this process raised when they were closed."""


@dataclass
class _Pending:
    """A change, and its new stages of this process, which wait to take over."""

    change: GraphChange
    stages: dict[str, Stage] = field(default_factory=dict)
    is_prepared: bool = False
    """Whether its stages of other processes were asked for."""
    ready_s: float | None = None
    """When all of its stages could take over, monotonic seconds."""
    answer: Answer = field(default_factory=Answer)
    is_done: threading.Event = field(default_factory=threading.Event)


class Changes:
    """A context in which a run can be changed: `ask` reaches it, on Linux, where the user has a state folder.

    Threads of its own read each request and check it as the graph's file is checked, make the new stages and reset
    them; those of other processes are made and reset there. The thread that fires calls `take` between two firings:
    only then do they take over. Nothing that arrives ends the run or keeps it waiting.
    """

    def __init__(self, run_id: str, graph: Graph, catalog: Catalog) -> None:
        self._run_id, self._began, self._catalog = run_id, graph, catalog
        self.graph = graph
        """The graph as it runs now."""
        self.made: list[dict[str, Any]] = []
        """The changes so far, for the summary."""
        self._listener: socket.socket | None = None
        self._path: Path | None = None
        self._threads: list[threading.Thread] = []
        self._begun, self._in_turn, self._lock = threading.Event(), threading.Lock(), threading.Lock()
        self._running: Running | None = None
        self._pending: _Pending | None = None
        self._has_ended = False

    @property
    def is_listening(self) -> bool:
        """Whether `ask` reaches it."""
        return self._listener is not None

    def __enter__(self) -> Self:
        path = RunningRun.socket_path(self._run_id) if is_linux() else None
        with suppress(OSError):
            self._listener = None if path is None else _listening(path)
            self._path = path
        if self._listener is not None:
            threading.Thread(target=self._accept, args=(self._listener,), name="graphnav-changes", daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self.end()
        if self._listener is not None:
            with suppress(OSError):
                self._listener.shutdown(socket.SHUT_RDWR)  # which also wakes the thread that accepts
            self._listener.close()
        if self._path is not None:
            with suppress(OSError):
                self._path.unlink()
        end_s = time.monotonic() + _END_S
        for thread in self._threads:
            thread.join(max(0.0, end_s - time.monotonic()))

    def begin(self, running: Running) -> None:
        """Let requests be checked: the stages of the run are wired and reset."""
        self._running = running
        self._begun.set()

    def end(self) -> None:
        """Tell those that wait that no change takes over any more."""
        with self._lock:
            self._has_ended, pending, self._pending = True, self._pending, None
        self._begun.set()
        if pending is not None:
            pending.is_done.set()

    def take(self, utime: int, sinks: Sequence[Any], *, is_busy: bool = False) -> None:
        """Let stages that are ready take over, between two firings; ``sinks`` get the `Changed` of each.

        ``utime``: the stamp from which on that counts. ``is_busy``: whether a stage could fire, for which they wait a
        little.
        """
        pending, running = self._pending, self._running
        if pending is None or running is None:
            return
        if pending.answer.at_s is None:
            if not self._is_ready(pending, running, is_busy=is_busy):
                return
            self._take_over(pending, running, utime, sinks)
        unclosed = [unit.unclosed() for unit in running.engine.remote_units(pending.change.nodes)]
        if all(errors is not None for errors in unclosed):
            self._finish(pending, _not_closed(error for errors in unclosed for error in errors or ()))

    def _is_ready(self, pending: _Pending, running: Running, *, is_busy: bool) -> bool:
        """Whether all stages of a change can take over now; refuse it if one of another process cannot be made."""
        nodes = pending.change.nodes
        units = running.engine.remote_units(nodes)
        if not pending.is_prepared:
            pending.is_prepared = True
            for unit in units:
                unit.prepare(pending.change.graph)
        told = [unit.prepared() for unit in units]
        problems = next((problems for problems in told if problems), ())
        if problems:
            for unit in units:
                unit.drop_prepared()
            running.hold(())
            pending.answer = Answer(problems=tuple(problems))
            self._finish(pending)
            return False
        if None in told:
            return False
        now_s = time.monotonic()
        pending.ready_s = now_s if pending.ready_s is None else pending.ready_s
        if is_busy and now_s - pending.ready_s < _BUSY_S:
            return False
        return running.hold({name for node in nodes for name in _held_for(node, self.graph.node(node.name))})

    def _finish(self, pending: _Pending, notices: Iterable[str] = ()) -> None:
        """Let a request be answered."""
        pending.answer = pending.answer._replace(notices=(*pending.answer.notices, *notices))
        with self._lock:
            self._pending = None
        pending.is_done.set()

    def _take_over(self, pending: _Pending, running: Running, utime: int, sinks: Sequence[Any]) -> None:
        engine, change = running.engine, pending.change
        failed = running.change(change.graph, change.nodes, pending.stages)
        self.graph = change.graph
        at_s = (utime - engine.begin_us) / 1e6
        for node in change.nodes:
            text = part_yaml(replace(change.graph, plugins=()), [node.name])
            changed = Changed(stage=node.name, use=node.use, words=change.words, stage_yaml=text)
            data = encode(changed, utime, engine.number(Changed.CHANNEL))
            for sink in sinks:
                sink.write(Changed.CHANNEL, utime, data)
            self.made.append({"at_s": round(at_s, 6), "stage": node.name, "use": node.use, "words": change.words})
        pending.answer = Answer(at_s, (*change.notices, *_not_closed(failed)))

    def _accept(self, listener: socket.socket) -> None:
        while not self._has_ended:
            try:
                link, _ = listener.accept()
            except OSError:
                return
            self._threads = [thread for thread in self._threads if thread.is_alive()]
            if peer_of(link)[1] != os.getuid():
                link.close()
                continue
            if len(self._threads) >= _MAX_REQUESTS:
                self._refuse(link)
                continue
            thread = threading.Thread(target=self._serve, args=(link,), name="graphnav-change", daemon=True)
            thread.start()
            self._threads.append(thread)

    def _refuse(self, link: socket.socket) -> None:
        what = f"run {self._run_id} has {_MAX_REQUESTS} requests to answer first"
        with closing(link), suppress(OSError):
            link.settimeout(0)
            link.sendall(Answer(problems=(Problem(None, what, "ask again later"),)).encoded())

    def _serve(self, link: socket.socket) -> None:
        with closing(link), suppress(OSError):
            try:
                answer = self._answer(Request.parse(_received(link)))
            except UserError as error:
                answer = Answer(problems=tuple(error.problems))
            except KeyboardInterrupt:  # the user ends the run
                answer = Answer()
            except Exception as error:  # noqa: BLE001 - whatever it is, the run goes on
                answer = Answer(problems=(Problem(None, f"the change cannot be checked: {one_line(error)}"),))
            link.settimeout(_PATIENCE_S)
            link.sendall(answer.encoded())

    def _answer(self, request: Request) -> Answer:
        """Return what became of a request, when it has taken over, or cannot any more."""
        self._begun.wait()
        with self._in_turn:
            running = self._running
            if running is None or self._has_ended:
                return Answer()
            with giving_way():
                pending = _Pending(request.change(self.graph, self._began, self._catalog))
            graph, nodes = pending.change.graph, pending.change.nodes
            elsewhere = {unit.node.name for unit in running.engine.remote_units(nodes)}
            try:
                with giving_way():
                    for node in nodes:
                        stage = graph.make_stage(node.name)  # those of other processes only to see whether it can be
                        if node.name not in elsewhere:
                            pending.stages[node.name] = stage
                            reset_stage(stage, node, graph.run.seed)
                self._wait_for_turn(pending)
            finally:
                if pending.answer.at_s is None:
                    for stage in pending.stages.values():
                        with suppress(Exception):
                            stage.close()
            return pending.answer

    def _wait_for_turn(self, pending: _Pending) -> None:
        """Wait until a change has taken over, or cannot any more."""
        with self._lock:
            if self._has_ended:
                return
            self._pending = pending
        pending.is_done.wait()


def reset_stage(stage: Stage, node: Node, run_seed: int) -> None:
    """Reset a new stage that is to take over; raises UserError if it raises."""
    try:
        with third_party_code():
            stage.reset(seed_of(run_seed, node.name))
    except CtrlC:
        raise
    except BaseException as error:
        hint = fix_the_plugin(error, (cls.__module__ for cls in node.stage_class.__mro__))
        problem = Problem(None, f"stage '{node.name}' ({node.use}) cannot be reset: {one_line(error)}", hint)
        raise UserError(problem) from error


def _held_for(node: Node, before: Node) -> Iterator[str]:
    """Yield the stages that make no step while one takes over: itself, and the writers of what it had not read before.

    In a replay steps take no time: what is published after the change must come from a step that began after it.
    """
    yield node.name
    same = node.same_inputs(before)
    yield from (i.channel.stage for i in node.inputs if i.channel is not None and i.port.name not in same)


def _not_closed(errors: Iterable[StageError]) -> Iterator[str]:
    return (f"not closed: {error}" for error in errors)


@contextmanager
def giving_way() -> Iterator[None]:
    """Let the thread that fires have Python's interpreter lock sooner than by default, 5 ms after it asks for it."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(_SWITCH_S)
    try:
        yield
    finally:
        sys.setswitchinterval(before)


def _listening(path: Path) -> socket.socket:
    """Return a socket that listens in a folder of this user alone; raises OSError if there is none."""
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    if not is_own(path.parent):
        raise PermissionError
    path.parent.chmod(0o700)
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        _in_folder(path, listener.bind)
        listener.listen(_MAX_REQUESTS)
    except OSError:
        listener.close()
        raise
    return listener


def _in_folder(path: Path, call: Callable[[str], None]) -> None:
    """Call ``call`` with an address for ``path`` that is short, however long the path is."""
    folder = os.open(path.parent, os.O_PATH | os.O_DIRECTORY)
    try:
        call(f"/proc/self/fd/{folder}/{path.name}")
    finally:
        os.close(folder)


def _received(link: socket.socket) -> bytes:
    """Return a request; raises UserError if it is too long, or not complete in time."""
    data, end_s = bytearray(), time.monotonic() + _PATIENCE_S
    while len(data) <= _MAX_BYTES:
        link.settimeout(max(1e-3, end_s - time.monotonic()))
        try:
            piece = link.recv(_MAX_BYTES)
        except TimeoutError:
            raise UserError.of(f"the request was not complete within {_PATIENCE_S:g} s") from None
        if not piece:
            return bytes(data)
        data += piece
    raise UserError.of(f"the request has more than {_MAX_BYTES} bytes")


def _answer(link: socket.socket, on_wait: Callable[[], None]) -> bytes:
    """Wait for all that a run answers."""
    data = bytearray()
    link.settimeout(_PATIENCE_S)
    while True:
        try:
            piece = link.recv(_MAX_BYTES)
        except TimeoutError:
            on_wait()
            link.settimeout(None)
            continue
        if not piece:
            return bytes(data)
        data += piece
