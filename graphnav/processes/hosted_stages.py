"""The stages of this process, which a run in another process steps."""

from __future__ import annotations

import signal
import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from graphnav import GraphnavError, Message
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Channel, part_of
from graphnav.core.interrupts import CtrlC, raise_ctrl_c
from graphnav.core.runner import LockstepEngine, decoded, difference_here
from graphnav.processes.frames import Frame, Kind, receive, send
from graphnav.processes.step_frames import InputsReceived, packed_error


def serve(link: socket.socket) -> None:
    """Answer the run until it closes its side."""
    stages: HostedStages | None = None
    with suppress(EOFError, OSError):
        while True:
            frame = receive(link)
            if stages is None:
                stages, said = _made(frame.head)
                send(link, Frame(Kind.ANSWER, said))
            else:
                send(link, stages.answer(frame))


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
        graph = part_of(setup["graph"], Path(setup["path"]), Catalog())
        self._read = frozenset(setup["read"])
        stages = graph.make_stages(self._read)
        self._nodes = graph.nodes
        self._engine = LockstepEngine(graph.nodes, stages, (), is_wired=False, published=self._keep)
        self._units = [self._engine.units[node.name] for node in graph.nodes]
        self._inputs: list[InputsReceived] = []
        self._n_fired: list[int] = []
        self._outputs: list[tuple[Channel, int, bytes]] = []
        self._answers: dict[int, Callable[[Any, Sequence[bytes]], Frame]] = {
            Kind.RESET: self._reset,
            Kind.FIRE: self._fire,
            Kind.METRICS: self._metrics,
            Kind.CLOSE: self._close,
        }

    def answer(self, frame: Frame) -> Frame:
        """Do what a frame asks for, and return the answer."""
        return self._answers[frame.kind](frame.head, frame.messages)

    def _reset(self, seed: int, _: Sequence[bytes]) -> Frame:
        self._inputs, self._n_fired = [InputsReceived(node) for node in self._nodes], [0] * len(self._nodes)
        return _called(lambda: self._engine.reset(seed))

    def _fire(self, head: tuple[int, int, Any], messages: Sequence[bytes]) -> Frame:
        place, utime, said = head
        unit = self._units[place]
        self._outputs = []
        outcome, failed, due = None, None, None
        n_steps, before_s = unit.durations.count, unit.durations.total_s
        try:
            with _interruptible():
                outcome = self._engine.fire(unit, utime, self._inputs[place].unpacked(said, messages), 0.0)
                for channel, _, data in self._outputs:
                    if channel.ref in self._read:
                        decoded(channel, data)  # what no reader could decode is an error of the writer
        except (GraphnavError, CtrlC) as error:
            failed = error
        self._n_fired[place] += 1
        if unit.node.is_source and failed is None:
            try:
                due = unit.due_us(self._n_fired[place])
            except GraphnavError as error:
                due = packed_error(error)
        ports = list(unit.node.outputs)
        done = {
            "outputs": [(ports.index(channel.port), stamp) for channel, stamp, _ in self._outputs],
            "outcome": outcome,
            "error": packed_error(failed),
            "took_s": unit.durations.total_s - before_s if unit.durations.count > n_steps else None,
            "due": due,
        }
        return Frame(Kind.ANSWER, done, tuple(data for _, _, data in self._outputs))

    def _metrics(self, place: int, _: Sequence[bytes]) -> Frame:
        return _called(self._units[place].metrics)

    def _close(self, head: tuple[int, float], _: Sequence[bytes]) -> Frame:
        place, at_s = head
        return _called(lambda: self._units[place].close(at_s))

    def _keep(self, channel: Channel, utime: int, _number: int, _message: Message, data: bytes) -> None:
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
