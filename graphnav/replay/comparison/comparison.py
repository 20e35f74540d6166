"""Compare the messages of a replay with the recorded messages of the same channels."""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict, deque
from collections.abc import Callable, Collection, Sequence
from typing import NamedTuple

from graphnav import Recording
from graphnav.core.codec import DecodeError, codec_of
from graphnav.core.graph import Channel
from graphnav.replay.comparison.field_differences import Tolerance, field_differences
from graphnav.replay.comparison.result import ChannelResult, FieldResult, FirstDifference
from graphnav.replay.log.contents import Contents, Logged

_SEQ_BEGIN, _SEQ_END = 16, 24
"""Position of the sequence number, after the fingerprint and the timestamp."""


class Scope(NamedTuple):
    """The scope of the comparison: messages published from ``from_us`` on, with a tolerance.

    ``begin_us``: the run's clock at its start. ``last_us``: the run's clock at the last tick or firing of the log,
    which may be incomplete. ``complete``: the channels of which the log keeps large messages, too. ``recorded``: the
    channels of the run, None if unknown.
    """

    begin_us: int
    from_us: int
    last_us: int
    tolerance: Tolerance
    complete: Collection[str]
    recorded: Collection[str] | None


class Comparison:
    """A sink that compares every message with the recorded one of the same timestamp.

    ``now_us`` returns the run's clock; set it before the first message.
    """

    def __init__(self, recording: Recording, channels: Sequence[Channel], contents: Contents, scope: Scope) -> None:
        self.now_us: Callable[[], int] = lambda: scope.begin_us
        self._channels = {
            channel.name: _ChannelComparison(recording, channel, contents, scope)
            for channel in channels
            if channel.name not in contents.other_types
        }

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Compare one message."""
        if (compared := self._channels.get(channel)) is not None:
            compared.take(utime, data, self.now_us())

    def results(self, until_us: int) -> dict[str, ChannelResult]:
        """Return the results by channel; recorded messages not published up to ``until_us`` are missing."""
        for compared in self._channels.values():
            compared.finish(until_us)
        return {name: compared.result for name, compared in self._channels.items()}


class _Gap:
    """Messages published between two timestamps that are not in the log."""

    def __init__(self, after_us: int, before_us: int, count: int) -> None:
        self.after_us, self.before_us, self.count = after_us, before_us, count


class _ChannelComparison:
    """Pairs the messages of one channel by their timestamps."""

    def __init__(self, recording: Recording, channel: Channel, contents: Contents, scope: Scope) -> None:
        logged = contents.messages[channel.name]
        self.result = ChannelResult()
        self._recording, self._name, self._scope = recording, channel.name, scope
        self._codec = codec_of(channel.message.lcm_class)
        is_of_run = scope.recorded is None or channel.name in scope.recorded
        self._is_expected = is_of_run and (bool(logged) or contents.is_own)
        self._waiting: dict[int, deque[Logged]] = defaultdict(deque)
        for message in logged:
            self._waiting[message.utime].append(message)
        self._gaps = _gaps(logged)

    def take(self, utime: int, data: bytes, now_us: int) -> None:
        """Compare a message published at ``now_us`` of the run's clock."""
        logged = waiting.popleft() if (waiting := self._waiting.get(utime)) else None
        at_us = now_us if logged is None else logged.at_us
        if at_us < self._scope.from_us:
            return
        if logged is None:
            self._take_unmatched(utime, len(data), now_us)
            return
        recorded = self._recording.event(self._name, logged.place).data
        self.result.n_compared += 1
        if recorded[:_SEQ_BEGIN] != data[:_SEQ_BEGIN] or recorded[_SEQ_END:] != data[_SEQ_END:]:
            self._compare_fields(at_us, recorded, data)

    def finish(self, until_us: int) -> None:
        """Count the recorded messages that were not published."""
        for waiting in self._waiting.values():
            for logged in waiting:
                if self._scope.from_us <= logged.at_us <= until_us:
                    self.result.n_missing += 1
                    self._note(FirstDifference(logged.at_us - self._scope.begin_us, "missing"))

    def _compare_fields(self, at_us: int, recorded: bytes, replayed: bytes) -> None:
        try:
            old = self._codec.decode(recorded)
        except DecodeError:
            self.result.n_compared -= 1
            self.result.n_not_recorded += 1
            return
        found = field_differences(old, self._codec.decode(replayed), self._scope.tolerance)
        for name, difference in found.items():
            at_run_us = at_us - self._scope.begin_us
            first = FirstDifference(
                at_run_us, "field", name, difference.where, difference.recorded, difference.replayed
            )
            known = self.result.fields.setdefault(name, FieldResult(first))
            known.n_messages += 1
            if difference.gap is not None:
                known.max_gap = max(difference.gap, known.max_gap or 0.0)
            self._note(first)
        self.result.n_differing += bool(found)

    def _take_unmatched(self, utime: int, n_bytes: int, now_us: int) -> None:
        """Count a message that is not in the log: it is extra, unless the log cannot hold it."""
        scope = self._scope
        is_after_end = now_us >= scope.last_us
        is_left_out = (self._name not in scope.complete and n_bytes >= Recording.SMALL_BYTES) or not self._is_expected
        if is_after_end or is_left_out or self._fills_gap(utime):
            self.result.n_not_recorded += 1
            return
        self.result.n_extra += 1
        self._note(FirstDifference(now_us - scope.begin_us, "extra"))

    def _fills_gap(self, utime: int) -> bool:
        place = bisect_left(self._gaps, utime, key=lambda gap: gap.after_us) - 1
        if place < 0 or not self._gaps[place].count or utime >= self._gaps[place].before_us:
            return False
        self._gaps[place].count -= 1
        return True

    def _note(self, found: FirstDifference) -> None:
        if self.result.first is None or found.at_us < self.result.first.at_us:
            self.result.first = found


def _gaps(logged: Sequence[Logged]) -> list[_Gap]:
    gaps = []
    last_seq, last_us = -1, -1
    for message in logged:
        if message.seq > last_seq + 1:
            gaps.append(_Gap(last_us, message.utime, message.seq - last_seq - 1))
        last_seq, last_us = max(message.seq, last_seq), max(message.utime, last_us)
    return gaps
