"""A stage in lockstep: fires when its plain inputs hold messages of the tick."""

from __future__ import annotations

import time
from typing import Any

from graphnav.graph import Node
from graphnav.messages import Message
from graphnav.runner.unit import Publish, Unit
from graphnav.stage import Latest, Since, Stage


class LockstepUnit(Unit):
    """Holds the messages that arrived for a stage and fires it when its plain inputs are complete."""

    def __init__(self, node: Node, stage: Stage, publish: Publish) -> None:
        super().__init__(node, stage, publish)
        self._n_dropped = 0
        self._inbox: dict[str, Any] = {}
        self._newest: dict[str, tuple[int, Message]] = {}
        self._gathered: dict[str, list[tuple[int, Message]]] = {port: [] for port in self._since}
        self._is_plain = frozenset(self._plain)
        unconnected = {i.port.name for i in node.inputs if i.channel is None}
        self._empty: dict[str, Latest[Any]] = {
            port: Latest(is_connected=port not in unconnected) for port in self._latest
        }

    def deliver(self, port: str, utime: int, message: Message) -> None:
        """Put a message into the inbox; messages on plain ports have the stamp of the tick."""
        if port in self._is_plain:
            self._inbox[port] = message
        elif port in self._gathered:
            self._gathered[port].append((utime, message))
        else:
            self._newest[port] = (utime, message)

    @property
    def dropped(self) -> int:
        """Number of sets of inputs that stayed incomplete."""
        return self._n_dropped

    @property
    def is_complete(self) -> bool:
        """Whether every plain input holds a message of this tick."""
        return len(self._inbox) == len(self._plain)

    def discard(self) -> None:
        """Drop and count an incomplete set."""
        if self._inbox:
            self._inbox.clear()
            self._n_dropped += 1

    def fire(self, utime: int) -> str | None:
        """Step once and publish; return the outcome if a source ended the run.

        Raises
        ------
        StageError
            The step raised, or returned something invalid.
        """
        inputs: dict[str, Any] = self._inbox
        self._inbox = {}
        for port in self._latest:
            inputs[port] = self._sample(port, utime)
        for port, gathered in self._gathered.items():
            inputs[port] = Since(tuple(gathered))
            gathered.clear()
        if self.node.deadline_ms is None:
            return self.step(utime, inputs)
        begin_s = time.perf_counter()
        outcome = self.step(utime, inputs)
        self.judge_deadline(begin_s, time.perf_counter())
        return outcome

    def _sample(self, port: str, utime: int) -> Latest[Any]:
        newest = self._newest.get(port)
        if newest is None:
            return self._empty[port]
        sent, message = newest
        return Latest(message, (utime - sent) / 1e6)
