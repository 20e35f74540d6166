"""The stages of this process, which a run in another process steps."""

from __future__ import annotations

import signal
import socket
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from graphnav import GraphnavError
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Channel, part_of
from graphnav.core.interrupts import CtrlC, raise_ctrl_c
from graphnav.core.runner import LiveStep, LockstepEngine, Timer, decoded, difference_here
from graphnav.processes.frames import Frame, Kind, keep_freed_memory, receive, send
from graphnav.processes.hosted_changes import HostedChanges
from graphnav.processes.step_frames import InputsReceived, packed_error


def serve(link: socket.socket) -> None:
    """Answer the run until it closes its side."""
    keep_freed_memory()
    stages: HostedStages | None = None
    sending = threading.Lock()

    def tell(frame: Frame) -> None:
        with sending:
            send(link, frame)

    with suppress(EOFError, OSError):
        while True:
            frame = receive(link)
            if stages is None:
                stages, said = _made(frame.head)
                tell(Frame(Kind.ANSWER, said))
            elif frame.kind == Kind.PREPARE:
                stages.changes.prepare(frame.head, tell)
            else:
                tell(stages.answer(frame))


def _made(setup: dict[str, Any]) -> tuple[HostedStages | None, Any]:
    """Return the stages and the answer of a set-up: nothing, or why they cannot be made."""
    try:
        if other := difference_here(setup["versions"], setup["plugins"]):
            return None, f"it does not have what the run began with, but {other}"
        return HostedStages(setup), None
    except GraphnavError as error:
        return None, f"it cannot make its stages: {error}"


class HostedStages:
    """Stages in an engine that is not wired: what they are given comes from the run, and what they publish goes there.

    ``setup``: the stages as `part_yaml` writes them, the graph's file, the references of the channels that are read.
    """

    def __init__(self, setup: dict[str, Any]) -> None:
        path, catalog = Path(setup["path"]), Catalog()
        graph = part_of(setup["graph"], path, catalog)
        self.changes = HostedChanges(path, catalog, {node.family for node in graph.nodes})
        """Makes what is to take the place of a stage."""
        self._read = frozenset(setup["read"])
        stages = graph.make_stages(self._read)
        self._engine = LockstepEngine(graph.nodes, stages, (), is_wired=False, published=self._keep)
        self._units = [self._engine.units[node.name] for node in graph.nodes]
        self._inputs: list[InputsReceived] = []
        self._n_fired: list[int] = []
        self._timers: dict[int, Timer] = {}
        """Of the sources of a live run, which skip firings that they have missed."""
        self._outputs: list[tuple[Channel, int, bytes]] = []
        self._answers: dict[int, Callable[[Any, Sequence[bytes]], Frame]] = {
            Kind.RESET: self._reset,
            Kind.FIRE: self._fire,
            Kind.DROP: self._drop,
            Kind.CHANGE: self._change,
            Kind.METRICS: self._metrics,
            Kind.CLOSE: self._close,
        }

    def answer(self, frame: Frame) -> Frame:
        """Do what a frame asks for, and return the answer."""
        return self._answers[frame.kind](frame.head, frame.messages)

    def _reset(self, order: tuple[int, int], _: Sequence[bytes]) -> Frame:
        seed, begin_us = order
        self._engine.begin_at(begin_us)
        self._inputs = [InputsReceived(unit.node) for unit in self._units]
        self._n_fired = [0] * len(self._units)
        self._timers.clear()

        def reset() -> list[float]:
            self._engine.reset(seed)
            return [unit.patience_s() if unit.node.has_since else 0.0 for unit in self._units]

        return _called(reset)

    def _fire(self, head: tuple[int, int, Any, Sequence[Any] | None], messages: Sequence[bytes]) -> Frame:
        place, utime, said, with_it = head
        live = None if with_it is None else LiveStep(*with_it)
        unit = self._units[place]
        self._outputs = []
        outcome, failed, due = None, None, None
        n_steps, before_s = unit.durations.count, unit.durations.total_s
        try:
            with _interruptible():
                inputs = self._inputs[place].unpacked(said, messages)
                if live is not None:
                    self._prepare(place, live)
                outcome = self._engine.fire(unit, utime, inputs, 0.0 if live is None else live.age_s)
                for channel, _, data in self._outputs:
                    if channel.ref in self._read:
                        decoded(channel, data)  # what no reader could decode is an error of the writer
        except (GraphnavError, CtrlC) as error:
            failed = error
        self._n_fired[place] += 1
        timer = self._timers.get(place)
        if unit.node.is_source and failed is None:
            try:
                due = unit.due_us(self._n_fired[place]) if timer is None else round(timer.due_s * 1e6)
            except GraphnavError as error:
                due = packed_error(error)
        ports = list(unit.node.outputs)
        done = {
            "outputs": [(ports.index(channel.port), stamp) for channel, stamp, _ in self._outputs],
            "outcome": outcome,
            "error": packed_error(failed),
            "took_s": unit.durations.total_s - before_s if unit.durations.count > n_steps else None,
            "due": due,
            "skipped": 0 if timer is None else timer.skipped,
        }
        return Frame(Kind.ANSWER, done, tuple(data for _, _, data in self._outputs))

    def _prepare(self, place: int, live: LiveStep) -> None:
        """Set the numbers of what a live step publishes, and let the timer of a source go on to its next firing."""
        unit = self._units[place]
        for channel, number in zip(unit.node.outputs.values(), live.numbers, strict=True):
            self._engine.set_next_number(channel.name, number)
        if live.run_s is not None:
            timer = self._timers.setdefault(place, Timer(lambda firing: unit.due_us(firing) * 1e-6, 0.0))
            timer.advance(live.run_s)

    def _drop(self, place: int, _: Sequence[bytes]) -> Frame:
        return _called(lambda: self.changes.drop(place))

    def _change(self, head: dict[str, Any], _: Sequence[bytes]) -> Frame:
        def change() -> list[Any]:
            made = self.changes.take(head)
            self._engine.utime, self._read = head["utime"], frozenset(head["read"])
            failed = self._engine.change(made.graph, [made.node], {made.node.name: made.stage})
            self._inputs[head["place"]] = InputsReceived(made.node)
            return [packed_error(error) for error in failed]

        return _called(change)

    def _metrics(self, place: int, _: Sequence[bytes]) -> Frame:
        return _called(self._units[place].metrics)

    def _close(self, head: tuple[int, float], _: Sequence[bytes]) -> Frame:
        place, at_s = head
        self.changes.drop(place)
        return _called(lambda: self._units[place].close(at_s))

    def _keep(self, channel: Channel, utime: int, _number: int, _message: object, data: bytes) -> None:
        self._outputs.append((channel, utime, data))


def _called(call: Callable[[], Any]) -> Frame:
    """Return what a call into a stage returns, or its error."""
    try:
        with _interruptible():
            return Frame(Kind.ANSWER, {"value": call(), "error": None})
    except (GraphnavError, CtrlC) as error:
        return Frame(Kind.ANSWER, {"value": None, "error": packed_error(error)})


@contextmanager
def _interruptible() -> Iterator[None]:
    """Let SIGINT, which the run sends when the user does not wait for a step any more, raise `CtrlC` in the block."""
    signal.signal(signal.SIGINT, raise_ctrl_c)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
