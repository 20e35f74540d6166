"""The log of the replay of a live run, which replays like that of the run itself."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from graphnav.live.firing import FIRED, Used, encoded_firing
from graphnav.replay.log.contents import Logged
from graphnav.runner.owned_stages import Sink


class FiringLog:
    """Writes what is played, what stages publish, and what they step with; events have the clock of the recorded run.

    Messages are numbered anew: the log may lack some of those that the recorded one holds.
    """

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._numbers: dict[tuple[str, int], int] = {}
        self._counts: Counter[str] = Counter()
        self._n_firings = 0

    def copy(self, message: Logged, data: bytes) -> int:
        """Write a message of the recorded log; return which one of its channel it is here."""
        number = self._numbers[message.channel, message.place] = self._counts[message.channel]
        self._counts[message.channel] += 1
        self._sink.write(message.channel, message.at_us, data)
        return number

    def number_of(self, channel: str, place: int) -> int:
        """Return which one of its channel a message of the recorded log is here, by its place there."""
        return self._numbers.get((channel, place), place)

    def publish(self, channel: str, at_us: int, data: bytes) -> None:
        """Write a message that a stage published now."""
        self._sink.write(channel, at_us, data)

    def fire(self, stage: str, at_us: int, utime: int, age_s: float, used: Sequence[Used]) -> None:
        """Write what a stage stepped with; ``utime``: the stamp of the step."""
        self._sink.write(FIRED, at_us, encoded_firing(at_us, stage, utime, self._n_firings, age_s, used))
        self._n_firings += 1
