"""Messages that wait for a stage in lockstep: those of the tick, and the newest of sampled inputs."""

from __future__ import annotations

from typing import Any

from graphnav.core.graph import Node
from graphnav.core.messages import Message
from graphnav.core.stage import Latest, Port, Since


class LockstepInbox:
    """Holds the messages of a stage until its plain inputs are complete."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._n_plain = sum(i.port.is_plain and i.channel is not None for i in node.inputs)
        self._n_dropped = 0
        self._inputs: dict[str, Any] = {}
        self._newest: dict[str, tuple[int, Message]] = {}
        self._gathered: dict[str, list[tuple[int, Message]]] = {i.port.name: [] for i in node.inputs if i.port.since}
        self._empty: dict[str, Latest[Any]] = {
            i.port.name: Latest(is_connected=i.channel is not None) for i in node.inputs if i.port.latest
        }

    def adopt(self, before: LockstepInbox) -> None:
        """Take the sampled and gathered messages of the stage before for inputs that read the same channel alike."""
        same = self._node.same_inputs(before._node)
        self._newest = {port: newest for port, newest in before._newest.items() if port in same}
        self._gathered |= {port: gathered for port, gathered in before._gathered.items() if port in same}
        self._n_dropped = before._n_dropped

    def put(self, port: Port, utime: int, _number: int, message: Message) -> None:
        """Add a message; those on plain ports have the stamp of the tick."""
        if port.latest:
            self._newest[port.name] = (utime, message)
        elif port.since:
            self._gathered[port.name].append((utime, message))
        else:
            self._inputs[port.name] = message

    @property
    def dropped(self) -> int:
        """Number of sets of inputs that stayed incomplete."""
        return self._n_dropped

    @property
    def is_complete(self) -> bool:
        """Whether every plain input holds a message of this tick."""
        return len(self._inputs) == self._n_plain

    def discard(self) -> None:
        """Drop and count an incomplete set."""
        if self._inputs:
            self._inputs.clear()
            self._n_dropped += 1

    def take(self, utime: int) -> dict[str, Any]:
        """Return the inputs of a step by port; `Latest` inputs stay."""
        inputs, self._inputs = self._inputs, {}
        for port, empty in self._empty.items():
            sent, message = self._newest.get(port, (0, None))
            inputs[port] = empty if message is None else Latest(message, (utime - sent) / 1e6)
        for port, gathered in self._gathered.items():
            inputs[port] = Since(tuple(gathered))
            gathered.clear()
        return inputs
