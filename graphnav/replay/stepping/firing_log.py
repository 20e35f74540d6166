"""Write the log of a replayed live run, which can be replayed like that of the run itself."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from graphnav.core.messages import Fired
from graphnav.core.runner import Sink, Taken
from graphnav.replay.log.contents import Logged


class FiringLog:
    """Writes played messages, published messages and firings; events have the clock of the recorded run.

    Messages are renumbered: the log may hold fewer of them than the recorded log. ``now_us``: returns that clock.
    """

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self.now_us: Callable[[], int] = lambda: 0
        self._numbers: dict[tuple[str, int], int] = {}
        self._counts: Counter[str] = Counter()
        self._n_firings = 0

    def copy(self, message: Logged, data: bytes) -> int:
        """Write a message of the recorded log; return its index on the channel in this log."""
        number = self._numbers[message.channel, message.place] = self._counts[message.channel]
        self._counts[message.channel] += 1
        self._sink.write(message.channel, message.at_us, data)
        return number

    def number_of(self, channel: str, place: int) -> int:
        """Return the index in this log of a message, by its index in the recorded log."""
        return self._numbers.get((channel, place), place)

    def write(self, channel: str, _utime: int, data: bytes) -> None:
        """Write a message published by a stage."""
        self._sink.write(channel, self.now_us(), data)

    def fire(self, stage: str, at_us: int, utime: int, taken: Taken) -> None:
        """Write a firing with its messages; ``utime``: the timestamp of the step."""
        self._sink.write(Fired.CHANNEL, at_us, taken.encoded(at_us, stage, utime, self._n_firings))
        self._n_firings += 1
