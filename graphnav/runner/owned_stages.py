"""The stages of a run or of a replay: made ready, closed, and what they publish numbered and encoded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Generic, Protocol, TypeVar

from graphnav.codec import EncodeError, encode
from graphnav.graph import Channel
from graphnav.messages import Message
from graphnav.runner.lifecycle import close_stages, reset_stages
from graphnav.runner.unit import Unit

U = TypeVar("U", bound=Unit)


class Sink(Protocol):
    """What takes every message of a run: the log, the tap."""

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Take one message as it was published."""


class OwnedStages(Generic[U]):
    """Owns stages; a subclass makes their units and says when which one fires.

    ``begin_us``: the clock at the beginning, 0 in simulated time.
    """

    def __init__(self, sinks: Sequence[Sink], begin_us: int = 0) -> None:
        self.ticks = 0
        """Ticks, or firings where there are no ticks."""
        self.utime = begin_us
        """The clock, microseconds."""
        self.is_ready = False
        """Whether every stage was reset."""
        self._units: dict[str, U] = {}
        self._begin_us = begin_us
        self._sinks = sinks
        self._seqs: dict[str, int] = {}

    @property
    def units(self) -> Mapping[str, U]:
        """The stages at work, by name."""
        return self._units

    def reset(self, seed: int) -> None:
        """Make every stage's state anew from ``seed`` and set the clock to the beginning.

        Raises
        ------
        StageError
            A stage cannot be made ready.
        """
        self._seqs.clear()
        self.is_ready = False
        self.ticks, self.utime = 0, self._begin_us
        reset_stages(self._units, seed)
        self.is_ready = True

    def close(self) -> None:
        """Release what the stages hold; each is closed, also if another one fails to.

        Raises
        ------
        StageError
            The first failure, once every stage was closed.
        """
        close_stages(self._units, (self.utime - self._begin_us) / 1e6)

    def _next_seq(self, channel: Channel) -> int:
        seq = self._seqs[channel.name] = self._seqs.get(channel.name, -1) + 1
        return seq

    def _give(self, channel: Channel, utime: int, seq: int, message: Message) -> bytes:
        """Encode a message, give it to every sink and return its bytes; raises ValueError where it cannot be."""
        try:
            data = encode(message, utime, seq)
        except EncodeError as error:
            raise ValueError(str(error)) from error
        for sink in self._sinks:
            sink.write(channel.name, utime, data)
        return data
