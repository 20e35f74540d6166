"""Receive ROS 2 topics in a thread, into the mailboxes of inputs, and note which publishers send."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable, Sequence
from functools import partial
from typing import NamedTuple

from graphnav.core.dds import Ros2Node
from graphnav.core.errors import BusError
from graphnav.core.ros2 import RosType
from graphnav.live.inputs.receiver import NEWEST, Takes

_POLL_S = 0.05
_MAX_SOURCES = 16
"""Maximum number of publishers that are kept for a topic; the one that has been silent longest is dropped."""


class Listened(NamedTuple):
    """A topic that is listened to, the mailbox that it fills, and how many messages wait for it in DDS.

    ``reliable``: lost packets are sent again, which keeps out publishers that do not do so.
    """

    topic: str
    kind: RosType
    mailbox: Takes
    depth: int = NEWEST
    reliable: bool = False


class TopicReceiver:
    """Listens to topics and fills mailboxes; ``wake`` is set on every arrival.

    It is the `PacketSources` of topics: DDS tells with each message who published it.
    """

    def __init__(self, node: Ros2Node, topics: Iterable[Listened], wake: threading.Event) -> None:
        self._node, self._wake = node, wake
        self._heard: dict[str, dict[int, float]] = {}
        for one in topics:
            self._heard[one.topic] = {}
            hear = partial(self._hear, one.topic, one.mailbox)
            node.subscribe(one.topic, one.kind, hear, one.depth, reliable=one.reliable)
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="graphnav-topics", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop listening; the participant stays."""
        self._ending.set()
        self._thread.join()

    def sender(self, topic: str, since_s: float, at_s: float) -> str:
        """Return the publisher of the message that arrived at ``at_s``, the only one since ``since_s``, else ""."""
        del at_s
        writers = self.writers(topic, since_s)
        return writers[0] if len(writers) == 1 else ""

    def writers(self, topic: str, since_s: float) -> Sequence[str]:
        """Return who published on a topic since a time, monotonic seconds."""
        heard = tuple(self._heard[topic].items())
        return [f"publisher {number:016x}" for number, at_s in sorted(heard) if at_s >= since_s]

    def _hear(self, topic: str, mailbox: Takes, data: bytes, publisher: int) -> None:
        at_s, heard = time.monotonic(), self._heard[topic]
        heard[publisher] = at_s
        if len(heard) > _MAX_SOURCES:
            del heard[min(heard, key=lambda one: heard[one])]
        if mailbox.put(data, at_s):
            self._wake.set()

    def _serve(self) -> None:
        while not self._ending.is_set():
            try:
                self._node.handle(_POLL_S)
            except BusError:
                self._ending.wait(_POLL_S)
