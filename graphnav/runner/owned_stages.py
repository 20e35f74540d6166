"""Own the stages of a run or a replay: reset and close them, number and encode their messages."""

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
    """A receiver of every message of a run: the log, the tap."""

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Write one message as it was published."""


class OwnedStages(Generic[U]):
    """Owns stages; a subclass creates their units and decides when each one fires.

    ``begin_us``: the clock at the start, 0 in simulated time.
    """

    def __init__(self, sinks: Sequence[Sink], begin_us: int = 0) -> None:
        self.ticks = 0
        """Number of ticks, or of firings if there are no ticks."""
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
        """The units of the stages, by name."""
        return self._units

    def reset(self, seed: int) -> None:
        """Reset the state of every stage from ``seed``, and the clock to the start.

        Raises
        ------
        StageError
            A stage cannot be reset.
        """
        self._seqs.clear()
        self.is_ready = False
        self.ticks, self.utime = 0, self._begin_us
        reset_stages(self._units, seed)
        self.is_ready = True

    def close(self) -> None:
        """Close every stage, even if another one fails to close.

        Raises
        ------
        StageError
            The first failure, after every stage was closed.
        """
        close_stages(self._units, (self.utime - self._begin_us) / 1e6)

    def _next_seq(self, channel: Channel) -> int:
        seq = self._seqs[channel.name] = self._seqs.get(channel.name, -1) + 1
        return seq

    def _give(self, channel: Channel, utime: int, seq: int, message: Message) -> bytes:
        """Encode a message, write it to every sink and return its bytes; raises ValueError if it cannot be encoded."""
        data = self._encode(channel, utime, seq, message)
        for sink in self._sinks:
            sink.write(channel.name, utime, data)
        return data

    def _encode(self, channel: Channel, utime: int, seq: int, message: Message) -> bytes:  # noqa: ARG002
        """Return a message's bytes; raises ValueError if it cannot be encoded. A subclass may measure it by channel."""
        try:
            return encode(message, utime, seq)
        except EncodeError as error:
            raise ValueError(str(error)) from error
