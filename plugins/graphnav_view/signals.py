"""Select the channels of a recording for its pictures."""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from graphnav import Flow, GraphnavError, Image, Message, Plane, State, Steering, Twist

if TYPE_CHECKING:
    from graphnav import Recording

M = TypeVar("M", bound=Message)

_OTHER_CLOCK_US = 3600 * 1_000_000
"""A logger stamps events by time of day: the simulated time of messages is decades behind."""


class Signals:
    """One channel of each message type: the one that drives the robot.

    If several channels carry one type (detectors side by side, twins), the one nearest upstream of the command
    that a stage consumes is shown, else of the steering, else of a plane; channels on which none of these depends
    follow in the graph's order.
    """

    def __init__(self, recording: Recording) -> None:
        self.graph: Mapping[str, Any] = _graph_of(recording)
        self.seed: int | None = recording.about.seed if recording.about is not None else None
        self._recording = recording
        self._order = list(_by_relevance(self.graph, recording.channels))
        self.begin_us = self._begin_us()
        """The origin of times."""

    def channel(self, kind: type[Message]) -> str | None:
        """Return the channel that carries ``kind``, None if the log has none."""
        types = self._recording.channels
        return next((name for name in self._order if types[name] is kind.lcm_class), None)

    def all(self, kind: type[M]) -> Iterator[tuple[int, M]]:
        """Yield stamp (microseconds) and message of the channel of ``kind``, oldest first; damaged ones are skipped."""
        channel = self.channel(kind)
        for index in range(self._recording.count(channel or "")):
            assert channel is not None
            try:
                utime, _, message = self._recording.message(channel, index)
            except GraphnavError:
                continue
            assert isinstance(message, kind)
            yield utime, message

    def first(self, kind: type[M]) -> M | None:
        """Return the first message of ``kind``."""
        return next((message for _, message in self.all(kind)), None)

    def at(self, kind: type[M], utime: int) -> M | None:
        """Return the message of ``kind`` that is stamped ``utime``, None if it is missing or damaged."""
        channel = self.channel(kind)
        if channel is None:
            return None
        stamps = self._recording.utimes(channel)
        index = bisect_left(stamps, utime)
        if index == len(stamps) or stamps[index] != utime:
            return None
        try:
            message = self._recording.message(channel, index)[2]
        except GraphnavError:
            return None
        assert isinstance(message, kind)
        return message

    def stamps(self, kind: type[Message]) -> list[int]:
        """Return the stamps (microseconds) of the channel of ``kind``."""
        channel = self.channel(kind)
        return [] if channel is None else self._recording.utimes(channel)

    def at_s(self, utime: int) -> float:
        """Return a stamp in seconds from the start of the log."""
        return (utime - self.begin_us) / 1e6

    def _begin_us(self) -> int:
        """Return the stamp of the log's first event, or of its first message if another clock stamped the events."""
        begin_us = self._recording.begin_us
        kinds = (Image, Flow, Plane, State)
        firsts = [self._recording.utimes(name)[0] for kind in kinds if (name := self.channel(kind)) is not None]
        return min(firsts) if firsts and max(firsts) < begin_us - _OTHER_CLOCK_US else begin_us

    def joined(self, *kinds: type[Message]) -> Iterator[tuple[int, tuple[Any, ...]]]:
        """Yield each stamp of the first kind with the messages of that stamp, None if a kind has none.

        Reads the log once, in order, and keeps one message of each kind in memory.
        """
        followers = [_Follower(self.all(kind)) for kind in kinds[1:]]
        for utime, message in self.all(kinds[0]):
            yield utime, (message, *(follower.at(utime) for follower in followers))


def _graph_of(recording: Recording) -> Mapping[str, Any]:
    """Return the graph of a log, empty if it is missing or damaged."""
    try:
        return recording.graph
    except GraphnavError:
        return {}


class _Follower:
    """A channel read in step with rising stamps."""

    def __init__(self, messages: Iterator[tuple[int, Message]]) -> None:
        self._messages = messages
        self._next = next(messages, None)

    def at(self, utime: int) -> Message | None:
        while self._next is not None and self._next[0] < utime:
            self._next = next(self._messages, None)
        return self._next[1] if self._next is not None and self._next[0] == utime else None


def _by_relevance(graph: Mapping[str, Any], channels: Mapping[str, type | None]) -> Iterator[str]:
    """Yield all channels of a log, the ones that drive the robot first."""
    wiring = _Wiring(graph, channels)
    seen: set[str] = set()
    queue: deque[str] = deque()
    for root in [*wiring.roots(), *wiring.stages]:
        queue.append(root)
        while queue:
            stage = queue.popleft()
            if stage in seen:
                continue
            seen.add(stage)
            yield from wiring.outputs[stage]
            queue += wiring.feeders(stage)
    yield from (name for name in channels if name not in wiring.writer)


class _Wiring:
    """Writers and readers of the channels of a log."""

    def __init__(self, graph: Mapping[str, Any], channels: Mapping[str, type | None]) -> None:
        self._types = channels
        self._renamed: Mapping[str, str] = graph.get("channels") or {}
        self.stages: Mapping[str, Any] = graph.get("stages") or {}
        ports = {self._renamed.get(port, port): port for port in [*self._renamed, *channels] if "." in port}
        self.writer = {
            channel: ports[channel].partition(".")[0]
            for channel in channels
            if channel in ports and ports[channel].partition(".")[0] in self.stages
        }
        self.outputs: dict[str, list[str]] = {stage: [] for stage in self.stages}
        for channel, stage in self.writer.items():
            self.outputs[stage].append(channel)

    def roots(self) -> Iterable[str]:
        """Return the stages from which the upstream search starts."""
        consumed = {channel for stage in self.stages for channel in self._inputs(stage)}
        for kind, wanted in ((Twist, consumed), (Steering, None), (Plane, None)):
            for stage in self.stages:
                for channel in self.outputs[stage]:
                    if self._types[channel] is kind.lcm_class and (wanted is None or channel in wanted):
                        yield stage

    def feeders(self, stage: str) -> list[str]:
        """Return the stages that ``stage`` reads."""
        return [self.writer[channel] for channel in self._inputs(stage) if channel in self.writer]

    def _inputs(self, stage: str) -> list[str]:
        found: list[str] = []
        for reference in (self.stages[stage].get("in") or {}).values():
            channel = self._renamed.get(reference, reference)
            found += [channel] if channel in self._types or "." in reference else self.outputs.get(reference, [])
        return found
