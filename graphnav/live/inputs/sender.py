"""Judging the messages of one input: which are used, how old they are, and what is wrong with their sender."""

from __future__ import annotations

import math
from collections import Counter
from typing import NamedTuple

from graphnav.live.inputs.delay import Delay
from graphnav.live.inputs.periods import Periods
from graphnav.live.inputs.timeline_candidate import Candidate
from graphnav.live.inputs.writer_stream import WriterStream

_MAX_GAP_PERIODS = 3.0
_DEFAULT_PERIODS = 5.0
_DEFAULT_MIN_S, _DEFAULT_MAX_S, _DEFAULT_UNKNOWN_S = 0.3, 5.0, 1.0
_ADOPTED_TIMELINE = 5
_ADOPTED_WRITER = 2

REPEATED, BACKWARDS, JUMPED, SECOND_WRITER = "repeated", "backwards", "jumped", "second writer"


class Verdict(NamedTuple):
    """What becomes of a message."""

    accepted: bool
    utime: int
    """Its stamp, microseconds of the sender's clock; that of the arrival where the type has none."""
    birth_s: float
    """Its arrival less how late it was, monotonic seconds; of a rejected message its arrival."""
    reason: str
    """Why it was rejected, empty if it was not."""
    begins_anew: bool
    """Whether it begins another timeline or is another writer's: stamps from before mean nothing beside its own."""


class _Arrived(NamedTuple):
    """A message, as far as it matters here."""

    stamp: int
    seq: int | None
    arrival_s: float
    delay_s: float


class SenderMonitor:
    """Judges the messages of one input in the order of their arrival, in constant time and memory.

    ``max_age_s``: older than this, the input counts as lost; a stamp that jumps by more than this against its arrival
    is a fault. None: 5 usual periods, at least 0.3 s and at most 5 s, 1 s before a period is known.

    Stamps that do not advance are rejected. A jump of the sender's clock is rejected until 5 consecutive messages
    agree on the new timeline and none came of the old one for 3 usual periods. A second writer, recognized by its
    sequence numbers, is rejected while the first one is alive. A message that was delayed on its way is accepted; its
    age tells.
    """

    def __init__(self, max_age_s: float | None = None) -> None:
        self.accepted = 0
        self.rejected: Counter[str] = Counter()
        """Messages that were not used, by reason."""
        self.missing = 0
        """Sequence numbers of the accepted writer that were skipped."""
        self._max_age_s = max_age_s
        self._newest: _Arrived | None = None
        self._birth_s = -math.inf
        self._delay: Delay | None = None
        self._periods = Periods()
        self._timeline: Candidate | None = None
        self._own: WriterStream | None = None
        self._own_heard_s = -math.inf
        self._other: tuple[WriterStream, Candidate] | None = None
        self._fault, self._fault_s = "", -math.inf

    @property
    def max_age_s(self) -> float:
        """The age in seconds above which the input counts as lost: the given one, or that of its usual period."""
        if self._max_age_s is not None:
            return self._max_age_s
        if self._periods.usual_s is None:
            return _DEFAULT_UNKNOWN_S
        return min(_DEFAULT_MAX_S, max(_DEFAULT_MIN_S, _DEFAULT_PERIODS * self._periods.usual_s))

    @property
    def offset_s(self) -> float:
        """The sender's clock less ours, seconds, estimated from the smallest delay; 0 before the first message."""
        return -self._delay.base_s if self._delay else 0.0

    def age_s(self, now_s: float) -> float:
        """Return the age of the newest accepted message at ``now_s`` (monotonic), infinite before the first."""
        return now_s - self._birth_s

    def rate_hz(self, now_s: float) -> float:
        """Return how many messages a second were accepted of late; 0 if the sender is silent at ``now_s``."""
        return self._periods.rate_hz(now_s, self.max_age_s)

    def fault(self, now_s: float) -> str:
        """Return what is wrong with the sender, empty once ``max_age_s`` passed since the last faulty message."""
        return self._fault if now_s - self._fault_s <= self.max_age_s else ""

    def reject(self, reason: str) -> None:
        """Count a message that was rejected elsewhere: undecodable, of another size, not finite."""
        self.rejected[reason] += 1

    def may_be_own(self, seq: int, arrival_s: float) -> bool:
        """Return whether a message with this number may be of the accepted writer, or that writer is gone.

        It is asked at arrival, by another thread, and may be asked long before `judge` is.
        """
        own = self._own
        if own is None:
            return True
        if own.continues(seq, arrival_s, self._periods.usual_s):
            self._own_heard_s = arrival_s
            return True
        return arrival_s - max(self._own_heard_s, own.arrival_s) > self.max_age_s

    def judge(self, arrival_s: float, arrival_utime: int, utime: int | None, seq: int | None) -> Verdict:
        """Judge the next message.

        ``arrival_s``: monotonic seconds at its arrival, never less than before. ``arrival_utime``: our clock then,
        microseconds. ``utime``: the sender's stamp, None if the type has none: the arrival's is used. ``seq``: the
        sender's count, None if the type has none.
        """
        newest = self._newest
        stamp = utime
        if stamp is None:
            stamp = arrival_utime if newest is None else max(arrival_utime, newest.stamp + 1)
        message = _Arrived(stamp, seq, arrival_s, (arrival_utime - stamp) / 1e6)
        if newest is None or self._delay is None:
            return self._adopt(message, message.delay_s, begins_anew=False)
        if seq is not None and self._own is not None and not (self._own.is_echo(seq) and stamp <= newest.stamp):
            if not self._is_own(self._own, seq, message):
                return self._judge_other(self._own, seq, message)
            self.missing += max(0, seq - self._own.seq - 1)
            self._own.add(seq, stamp, arrival_s)
        return self._judge_stamp(newest, self._delay, message)

    def _judge_stamp(self, newest: _Arrived, delay: Delay, message: _Arrived) -> Verdict:
        """Judge a message of the accepted writer by its stamp."""
        max_age_s, timeline = self.max_age_s, self._timeline
        advance_s = (message.stamp - newest.stamp) / 1e6
        elapsed_s = message.arrival_s - newest.arrival_s
        if advance_s == 0:
            self._timeline = None
            return self._rejected(message, REPEATED)
        if timeline is not None and message.stamp == timeline.stamp:
            return self._rejected(message, REPEATED)
        is_ahead = delay.is_ahead(message.delay_s, message.arrival_s, max_age_s)
        # A stamp may lag as far as its arrival was late, which is what the wait exceeds a period by.
        if is_ahead or min(elapsed_s, self._periods.usual_s or 0.0) - advance_s > max_age_s:
            self._note(f"the stamp jumped by {advance_s - elapsed_s:+.1f} s against its arrival", message)
            if timeline is None:
                self._timeline = timeline = Candidate(message.stamp, message.arrival_s, message.delay_s)
            else:
                timeline.add(message.stamp, message.arrival_s, message.delay_s, max_age_s)
            if timeline.count >= _ADOPTED_TIMELINE and elapsed_s > _MAX_GAP_PERIODS * (self._periods.usual_s or 0.0):
                return self._adopt(message, timeline.min_delay_s, begins_anew=True)
            return self._rejected(message, JUMPED)
        if advance_s < 0:
            return self._rejected(message, BACKWARDS)
        self._periods.add(advance_s)
        delay.add(message.delay_s, message.arrival_s)
        return self._accepted(message, delay, begins_anew=False)

    def _is_own(self, own: WriterStream, seq: int, message: _Arrived) -> bool:
        """Return whether a message is of the accepted writer; of two streams that it continues, the better one."""
        period_s = self._periods.usual_s
        if not own.continues(seq, message.arrival_s, period_s):
            return False
        if self._other is None or not (other := self._other[0]).continues(seq, message.arrival_s, period_s):
            return True
        return own.error_us(seq, message.stamp) <= other.error_us(seq, message.stamp)

    def _judge_other(self, own: WriterStream, seq: int, message: _Arrived) -> Verdict:
        """Judge a message of another writer; a sender that was restarted is one, too."""
        max_age_s, arrival_s = self.max_age_s, message.arrival_s
        self._note(f"a second writer: seq {seq} does not go on from {own.seq}", message)
        if arrival_s - own.arrival_s > max_age_s and self._other is None:
            self._periods.forget()
            return self._adopt(message, message.delay_s, begins_anew=True)
        if self._other is None or arrival_s - self._other[0].arrival_s > max_age_s:
            fresh = Candidate(message.stamp, arrival_s, message.delay_s)
            self._other = WriterStream(seq, message.stamp, arrival_s), fresh
            return self._rejected(message, SECOND_WRITER)
        other, candidate = self._other
        if not other.continues(seq, arrival_s, self._periods.usual_s):
            return self._rejected(message, SECOND_WRITER)
        other.add(seq, message.stamp, arrival_s)
        candidate.add(message.stamp, arrival_s, message.delay_s, max_age_s)
        if candidate.count < _ADOPTED_WRITER or arrival_s - own.arrival_s <= max_age_s:
            return self._rejected(message, SECOND_WRITER)
        self._periods.forget()
        return self._adopt(message, candidate.min_delay_s, begins_anew=True)

    def _adopt(self, message: _Arrived, base_s: float, *, begins_anew: bool) -> Verdict:
        """Accept the first message of a timeline or a writer."""
        self._delay = Delay(base_s, message.arrival_s)
        self._own = self._other = None
        return self._accepted(message, self._delay, begins_anew=begins_anew)

    def _accepted(self, message: _Arrived, delay: Delay, *, begins_anew: bool) -> Verdict:
        self.accepted += 1
        self._newest, self._timeline = message, None
        if self._own is None and message.seq is not None:
            self._own = WriterStream(message.seq, message.stamp, message.arrival_s)
        self._periods.arrive(message.arrival_s, begins_anew=begins_anew)
        self._birth_s = message.arrival_s - delay.lateness_s(message.delay_s, self.max_age_s)
        return Verdict(accepted=True, utime=message.stamp, birth_s=self._birth_s, reason="", begins_anew=begins_anew)

    def _rejected(self, message: _Arrived, reason: str) -> Verdict:
        self.reject(reason)
        return Verdict(accepted=False, utime=message.stamp, birth_s=message.arrival_s, reason=reason, begins_anew=False)

    def _note(self, fault: str, message: _Arrived) -> None:
        self._fault, self._fault_s = fault, message.arrival_s
