"""The data of a viewer: all channels of a feed, their newest messages and stored older ones."""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple, Protocol, TypeVar

from graphnav import Message
from graphnav.watch.spy.feed import Received
from graphnav.watch.spy.traffic import ChannelTraffic, Traffic
from graphnav.watch.spy.watch.row import Row

M = TypeVar("M", bound=Message)

KEPT_MESSAGES = 600
"""The number of small messages stored per channel for plots and paths."""
KEPT_BYTES = 512


class Sample(NamedTuple):
    """A message: its time of arrival or recording (seconds on the feed's clock), and its bytes."""

    at_s: float
    data: bytes


class Watch(Protocol):
    """A watched feed, live or recorded; all methods may be called from any one thread."""

    name: str
    is_live: bool

    @property
    def version(self) -> object:
        """A value that changes whenever there is new data."""

    @property
    def origin_s(self) -> float:
        """The origin of displayed times: now if live, the beginning of a log."""

    def start(self) -> None:
        """Start receiving or reading."""

    def close(self) -> None:
        """Close the network or the file."""

    def rows(self) -> list[Row]:
        """Return the channels, in order of their first message or announcement."""

    def channel(self, name: str) -> ChannelTraffic | None:
        """Return the statistics of a channel."""

    def newest(self, name: str) -> Sample | None:
        """Return the newest message of a channel."""

    def recent(self, name: str, after_s: float) -> list[Sample]:
        """Return the stored messages of a channel that arrived after ``after_s``, oldest first."""

    def names_of(self, lcm_class: type) -> list[str]:
        """Return the channels that carry a type."""

    def why_empty(self, name: str | None) -> str:
        """Return why there are no new messages of a channel, or of any; empty if there are."""

    def heading(self) -> str:
        """Return a short line about the feed."""


class Memory:
    """Traffic and stored messages, guarded by a lock: one thread receives, another one reads."""

    def __init__(self, traffic: Traffic) -> None:
        self.traffic = traffic
        self.lock = threading.Lock()
        self._newest: dict[str, Sample] = {}
        self._kept: dict[str, deque[Sample]] = {}

    def receive(self, received: Received) -> None:
        """Store a message, unless its channel is beyond the limit."""
        with self.lock:
            self.traffic.receive(received)
            if received.channel not in self.traffic.channels:
                return
            sample = Sample(received.at_s, received.data)
            self._newest[received.channel] = sample
            if len(received.data) <= KEPT_BYTES:
                kept = self._kept.get(received.channel)
                if kept is None:
                    kept = self._kept[received.channel] = deque(maxlen=KEPT_MESSAGES)
                kept.append(sample)

    def newest(self, name: str) -> Sample | None:
        """Return the newest message of a channel."""
        with self.lock:
            return self._newest.get(name)

    def recent(self, name: str, after_s: float) -> list[Sample]:
        """Return the stored messages that arrived after ``after_s``, oldest first."""
        with self.lock:
            kept = self._kept.get(name, ())
            return [sample for sample in kept if sample.at_s > after_s]

    def names_of(self, lcm_class: type) -> list[str]:
        """Return the channels whose newest message is of a type."""
        with self.lock:
            channels = self.traffic.channels
            return [name for name in self._newest if name in channels and channels[name].lcm_class is lcm_class]
