"""What a viewer looks at: all channels of a feed, their newest messages and what is kept of the ones before."""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple, Protocol, TypeVar

from graphnav.messages import Message
from graphnav.spy.feed import Received
from graphnav.spy.traffic import ChannelTraffic, Traffic
from graphnav.spy.watch.row import Row

M = TypeVar("M", bound=Message)

KEPT_MESSAGES = 600
"""Of each channel so many messages are kept for plots and paths, if they are small."""
KEPT_BYTES = 512


class Sample(NamedTuple):
    """A message: when it arrived, or was recorded (seconds on the feed's clock), and its bytes."""

    at_s: float
    data: bytes


class Watch(Protocol):
    """A feed that is being watched, live or recorded; all methods may be called from any one thread."""

    name: str
    is_live: bool

    @property
    def version(self) -> object:
        """What differs from what it was before where there is anything new to see."""

    @property
    def origin_s(self) -> float:
        """What times are told from: now where it is live, the begin of a log."""

    def start(self) -> None:
        """Begin to listen, or to read."""

    def close(self) -> None:
        """Let go of the network or the file."""

    def rows(self) -> list[Row]:
        """Return the channels, in the order in which they were first received of."""

    def channel(self, name: str) -> ChannelTraffic | None:
        """Return what is known of a channel."""

    def newest(self, name: str) -> Sample | None:
        """Return the newest message of a channel."""

    def recent(self, name: str, after_s: float) -> list[Sample]:
        """Return the kept messages of a channel that came after ``after_s``, oldest first."""

    def names_of(self, lcm_class: type) -> list[str]:
        """Return the channels that carry a type."""

    def why_empty(self, name: str | None) -> str:
        """Return why there is nothing of a channel, or of any: empty where there is something and it is new."""

    def heading(self) -> str:
        """Return what there is to say of the feed in few words."""


class Memory:
    """Traffic and kept messages, guarded by a lock: one thread receives, another one looks."""

    def __init__(self, traffic: Traffic) -> None:
        self.traffic = traffic
        self.lock = threading.Lock()
        self._newest: dict[str, Sample] = {}
        self._kept: dict[str, deque[Sample]] = {}

    def receive(self, received: Received) -> None:
        """Take a message; of channels beyond the limit nothing is kept."""
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
        """Return the kept messages that came after ``after_s``, oldest first."""
        with self.lock:
            kept = self._kept.get(name, ())
            return [sample for sample in kept if sample.at_s > after_s]

    def names_of(self, lcm_class: type) -> list[str]:
        """Return the channels whose newest message is of a type."""
        with self.lock:
            channels = self.traffic.channels
            return [name for name in self._newest if name in channels and channels[name].lcm_class is lcm_class]
