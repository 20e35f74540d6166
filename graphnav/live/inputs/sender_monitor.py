"""Judge the messages of one input: whether they are used, their age, and faults of their sender."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from graphnav.live.inputs.delay import Delay
from graphnav.live.inputs.periods import Periods
from graphnav.live.inputs.stamp_clock import StampClock
from graphnav.live.inputs.writer_stream import Candidate, WriterStream

_MAX_GAP_PERIODS = 3.0
_DEFAULT_PERIODS = 5.0
_DEFAULT_MIN_S, _DEFAULT_MAX_S, _DEFAULT_UNKNOWN_S = 0.3, 5.0, 1.0
_ADOPTED_TIMELINE = 5
_ADOPTED_WRITER = 2

REPEATED, BACKWARDS, JUMPED = "repeated", "backwards", "jumped"
SECOND_WRITER, RESTARTED = "second writer", "restarted"


class Verdict(NamedTuple):
    """The decision on a message."""

    accepted: bool
    utime: int
    """Its stamp in microseconds of the sender's clock; the time of arrival if the type has none."""
    birth_s: float
    """Its arrival minus its lateness, monotonic seconds; the arrival for a rejected message."""
    reason: str
    """Reason of the rejection, empty if it was accepted."""
    is_restart: bool
    """Whether it begins a new timeline or is from a new writer: earlier stamps are not comparable with its own."""


class _Arrived(NamedTuple):
    """The properties of a message that decide on it."""

    stamp: int
    seq: int | None
    arrival_s: float
    arrival_utime: int
    writer: str
    """The program that sent it, empty if that is not known."""

    @property
    def delay_s(self) -> float:
        """Its arrival by our clock less its stamp, in seconds."""
        return (self.arrival_utime - self.stamp) / 1e6


class _Other:
    """Another writer than the accepted one: its stream, its timeline and its arrivals."""

    def __init__(self, seq: int, message: _Arrived) -> None:
        self.stream = WriterStream(seq, message.stamp, message.arrival_s)
        self.timeline = Candidate(message.stamp, message.arrival_s, message.delay_s)
        self._periods = Periods()
        self._periods.arrive(message.arrival_s, is_restart=True)

    def add(self, seq: int, message: _Arrived, max_age_s: float) -> None:
        """Add its next message."""
        self.stream.add(seq, message.stamp, message.arrival_s)
        self.timeline.add(message.stamp, message.arrival_s, message.delay_s, max_age_s)
        self._periods.arrive(message.arrival_s, is_restart=False)

    def rate_hz(self, max_age_s: float) -> float:
        """Return the rate of its messages when the last one arrived."""
        return self._periods.rate_hz(self.stream.arrival_s, max_age_s)


class SenderMonitor:
    """Judges the messages of one input in the order of their arrival, in constant time and memory.

    ``max_age_s``: older than this, the input counts as lost; a stamp that jumps by more than this against its arrival
    is a fault. None: 5 typical periods, at least 0.3 s and at most 5 s, 1 s before a period is known.

    Stamps that do not advance are rejected. A jump of the sender's clock is rejected until 5 consecutive messages
    agree on the new timeline and none of the old one has arrived for 3 typical periods. A message delayed in the
    network is accepted; its age includes the delay.

    One writer is used. It is accepted for good when it was alone for ``max_age_s``; a second one, told by its sequence
    numbers, is then rejected and does no harm. When the accepted writer has been silent for ``max_age_s``, another one
    takes over, with a fault for as long, so that a robot stops in between. A second writer that comes before that, or
    uses the same numbers, or none, is a fault: neither is used until one has been silent for ``max_age_s``.

    Numbers of the one program that sends which do not follow those before are not of a second writer: it has started
    again. That is told, and handled in the same way.
    """

    def __init__(self, max_age_s: float | None = None) -> None:
        self.accepted = 0
        self.rejected: Counter[str] = Counter()
        """Rejected messages by reason."""
        self._details: dict[str, tuple[str, float]] = {}
        self.missing = 0
        """Number of skipped sequence numbers of the accepted writer, less the messages whose number was not read."""
        self.unread = 0
        """Messages since the last one of the accepted writer whose number could not be read."""
        self._max_age_s = max_age_s
        self._newest: _Arrived | None = None
        self._birth_s = -math.inf
        self._delay: Delay | None = None
        self._stamps = StampClock()
        self._periods = Periods()
        self._timeline: Candidate | None = None
        self._own: WriterStream | None = None
        self._own_heard_s = -math.inf
        self._own_program = ""
        """The program that sent the newest accepted message whose program is known."""
        self._other: _Other | None = None
        self._alone_since_s = math.inf
        self._is_contested = self._is_mixed = self._is_restarted = False
        self._fault, self._fault_s = "", -math.inf

    @property
    def max_age_s(self) -> float:
        """The age in seconds above which the input counts as lost: as given, or derived from its typical period."""
        if self._max_age_s is not None:
            return self._max_age_s
        if self._periods.usual_s is None:
            return _DEFAULT_UNKNOWN_S
        return min(_DEFAULT_MAX_S, max(_DEFAULT_MIN_S, _DEFAULT_PERIODS * self._periods.usual_s))

    @property
    def offset_s(self) -> float:
        """The sender's clock minus ours in seconds, estimated from the smallest delay; 0 before the first message."""
        return -self._delay.base_s if self._delay else 0.0

    @property
    def stamp_fault(self) -> str:
        """The fault of all stamps of the sender, such as their unit; empty if they are right."""
        return self._stamps.fault

    @property
    def has_boot_time(self) -> bool:
        """Whether the stamps are of this machine's CLOCK_MONOTONIC."""
        return self._stamps.is_boot_time

    @property
    def counts_offset(self) -> bool:
        """Whether the offset is less than ``max_age_s``, so that it counts as delay."""
        return self._delay is None or self._delay.agrees

    def age_s(self, now_s: float) -> float:
        """Return the age of the newest accepted message at ``now_s`` (monotonic), infinite before the first."""
        return now_s - self._birth_s

    def rate_hz(self, now_s: float) -> float:
        """Return the recent rate of accepted messages; 0 if the sender is silent at ``now_s``."""
        return self._periods.rate_hz(now_s, self.max_age_s)

    def fault(self, now_s: float) -> str:
        """Return the fault of the sender: of its stamps, else of a message that is not older than ``max_age_s``."""
        if self._stamps.fault:
            return self._stamps.fault
        return self._fault if now_s - self._fault_s <= self.max_age_s else ""

    def reject(self, reason: str, detail: str = "", at_s: float = math.inf, count: int = 1) -> None:
        """Count rejected messages; ``detail``: the field, its value and what is allowed, of the last, at ``at_s``."""
        self.rejected[reason] += count
        self._details[reason] = detail, at_s

    def detail(self, reason: str, since_s: float = -math.inf) -> str:
        """Return the detail of the last message rejected for a reason, empty if it came before ``since_s``."""
        text, at_s = self._details.get(reason, ("", -math.inf))
        return text if at_s >= since_s else ""

    def may_be_own(self, seq: int, arrival_s: float) -> bool:
        """Return whether a message with this number may be from the accepted writer, or that writer is gone.

        Called at arrival, by another thread, possibly long before `judge`.
        """
        own = self._own
        if own is None:
            return True
        if own.continues(seq, arrival_s, self._periods.usual_s):
            self._own_heard_s = arrival_s
            return True
        return arrival_s - max(self._own_heard_s, own.arrival_s) > self.max_age_s

    def judge(
        self,
        arrival_s: float,
        arrival_utime: int,
        utime: int | None,
        seq: int | None,
        writers: Sequence[str] = (),
        sender: str = "",
    ) -> Verdict:
        """Judge the next message.

        ``arrival_s``: its arrival in monotonic seconds, non-decreasing. ``arrival_utime``: our clock at its arrival in
        microseconds. ``utime``: the sender's stamp, None if the type has none: then the arrival is used. ``seq``: the
        sender's sequence number, None if the type has none. ``writers``: the programs that sent on the channel within
        the last ``max_age_s``, as far as they are known; they count where sequence numbers do not.
        ``sender``: the only one of them, if it is known to have sent this message.
        """
        newest = self._newest
        stamp = utime
        if stamp is None:
            stamp = arrival_utime if newest is None else max(arrival_utime, newest.stamp + 1)
        message = _Arrived(stamp, seq, arrival_s, arrival_utime, sender)
        if newest is None or self._delay is None:
            self._alone_since_s = arrival_s
            return self._adopt(message, message.delay_s, is_restart=False)
        own = self._own
        if seq is not None and own is not None and not self._is_echo(own, seq, message, newest):
            is_twin = own.is_twin(seq, stamp)
            if is_twin or not self._is_own(own, seq, message):
                self._compare_program(message)
                return self._judge_other(own, seq, message, is_twin=is_twin)
            self.missing += max(0, seq - own.seq - 1 - self.unread)
            self.unread = 0
            own.add(seq, stamp, arrival_s)
        if own is None or not own.is_counting:
            if len(writers) > 1:
                return self._reject_mixed(message, writers)
            if self._is_mixed:
                return self._adopt_alone(message)
        if self._is_contested and own is not None:
            return self._judge_contested(own, message)
        return self._judge_stamp(newest, self._delay, message)

    def _is_echo(self, own: WriterStream, seq: int, message: _Arrived, newest: _Arrived) -> bool:
        """Return whether a message is a duplicate, or was overtaken in the network."""
        return own.is_echo(seq) and message.stamp <= newest.stamp and not own.is_twin(seq, message.stamp)

    def _judge_stamp(self, newest: _Arrived, delay: Delay, message: _Arrived) -> Verdict:
        """Judge a message of the accepted writer by its stamp."""
        max_age_s, timeline = self.max_age_s, self._timeline
        self._stamps.add(message.stamp, message.arrival_s, message.arrival_utime)
        advance_s = (message.stamp - newest.stamp) / 1e6
        elapsed_s = message.arrival_s - newest.arrival_s
        if advance_s == 0:
            self._timeline = None
            return self._rejected(message, REPEATED, "utime is that of an earlier message, expected a later time")
        if timeline is not None and message.stamp == timeline.stamp:
            return self._rejected(message, REPEATED, "utime is that of an earlier message, expected a later time")
        is_ahead = delay.is_ahead(message.delay_s, message.arrival_s, max_age_s)
        # A stamp may lag by as much as its arrival was late: the excess of the wait over a period.
        if is_ahead or min(elapsed_s, self._periods.usual_s or 0.0) - advance_s > max_age_s:
            self._note(f"the stamp jumped by {advance_s - elapsed_s:+.1f} s against its arrival", message)
            if timeline is None:
                self._timeline = timeline = Candidate(message.stamp, message.arrival_s, message.delay_s)
            else:
                timeline.add(message.stamp, message.arrival_s, message.delay_s, max_age_s)
            if timeline.count >= _ADOPTED_TIMELINE and elapsed_s > _MAX_GAP_PERIODS * (self._periods.usual_s or 0.0):
                return self._adopt(message, timeline.min_delay_s, is_restart=True)
            return self._rejected(message, JUMPED, self._fault)
        if advance_s < 0:
            return self._rejected(
                message, BACKWARDS, f"utime is {-advance_s:.3f} s before that of the newest, expected later"
            )
        self._periods.add(advance_s)
        delay.add(message.delay_s, message.arrival_s)
        return self._accepted(message, delay, is_restart=False)

    def _is_own(self, own: WriterStream, seq: int, message: _Arrived) -> bool:
        """Return whether a message is from the accepted writer; if it continues two streams, the better match wins."""
        period_s = self._periods.usual_s
        if not own.continues(seq, message.arrival_s, period_s):
            return False
        if self._other is None or not (other := self._other.stream).continues(seq, message.arrival_s, period_s):
            return True
        return own.error_us(seq, message.stamp) <= other.error_us(seq, message.stamp)

    def _judge_other(self, own: WriterStream, seq: int, message: _Arrived, *, is_twin: bool) -> Verdict:
        """Judge a message that does not continue the accepted stream: of another writer, or of a restarted sender."""
        max_age_s, arrival_s, other = self.max_age_s, message.arrival_s, self._other
        is_own_silent = arrival_s - own.arrival_s > max_age_s
        if other is None or arrival_s - other.stream.arrival_s > max_age_s:
            if is_own_silent:
                return self._take_over(own, seq, message, message.delay_s, alone_since_s=arrival_s)
            self._other = other = _Other(seq, message)
            if not self._is_restarted:
                self._is_contested |= is_twin or arrival_s - self._alone_since_s <= max_age_s
        elif other.stream.continues(seq, arrival_s, self._periods.usual_s):
            other.add(seq, message, max_age_s)
            if is_own_silent and other.timeline.count >= _ADOPTED_WRITER:
                return self._take_over(own, seq, message, other.timeline.min_delay_s, alone_since_s=-math.inf)
        if self._is_restarted:
            self.unread += 1
            return self._rejected(message, RESTARTED, _restart(own, seq, message))
        if self._is_contested:
            return self._reject_contested(own, other, message)
        detail = f"seq {other.stream.seq} beside {own.seq}, {other.rate_hz(max_age_s):.1f} Hz; the first writer is used"
        return self._rejected(message, SECOND_WRITER, detail)

    def _compare_program(self, message: _Arrived) -> None:
        """Note whether a message that does not continue the accepted stream is from the same, only, program."""
        before, self._is_restarted = self._is_restarted, bool(message.writer) and message.writer == self._own_program
        if before and not self._is_restarted:
            self._other = None  # the packet of another program was noted after its message

    def _take_over(
        self, own: WriterStream, seq: int, message: _Arrived, base_s: float, *, alone_since_s: float
    ) -> Verdict:
        """Accept another writer; the fault lets a robot stop once in between."""
        if self._is_restarted:
            self._note(_restart(own, seq, message), message)
        else:
            self._note(f"another writer took over: seq {seq} after {own.seq}", message)
            self._own_program = ""
        self._alone_since_s, self._is_contested = alone_since_s, False
        self._periods.forget()
        return self._adopt(message, base_s, is_restart=True)

    def _judge_contested(self, own: WriterStream, message: _Arrived) -> Verdict:
        """Judge a message of the first of two writers of which none is accepted yet."""
        other = self._other
        if other is None or message.arrival_s - other.stream.arrival_s > self.max_age_s:
            return self._adopt_alone(message)
        return self._reject_contested(own, other, message)

    def _reject_contested(self, own: WriterStream, other: _Other, message: _Arrived) -> Verdict:
        fault = f"two writers: seq {own.seq} and seq {other.stream.seq}; neither is used until one of them ends"
        self._note(fault, message)
        return self._rejected(message, SECOND_WRITER, fault)

    def _reject_mixed(self, message: _Arrived, writers: Sequence[str]) -> Verdict:
        """Reject a message without a number, which any of several writers may have sent."""
        self._is_mixed = True
        fault = f"{len(writers)} writers without sequence numbers: {', '.join(writers)}; none is used until one remains"
        self._note(fault, message)
        return self._rejected(message, SECOND_WRITER, fault)

    def _adopt_alone(self, message: _Arrived) -> Verdict:
        """Accept the only writer that remains of several."""
        self._alone_since_s, self._is_contested, self._is_mixed = -math.inf, False, False
        self._own_program = ""
        return self._adopt(message, message.delay_s, is_restart=True)

    def _adopt(self, message: _Arrived, base_s: float, *, is_restart: bool) -> Verdict:
        """Accept the first message of a timeline or a writer."""
        self._delay = Delay(base_s, message.arrival_s)
        self._stamps = StampClock()
        self._stamps.add(message.stamp, message.arrival_s, message.arrival_utime)
        self._own = self._other = None
        self._is_restarted, self.unread = False, 0
        return self._accepted(message, self._delay, is_restart=is_restart)

    def _accepted(self, message: _Arrived, delay: Delay, *, is_restart: bool) -> Verdict:
        self.accepted += 1
        self._newest, self._timeline = message, None
        self._own_program = message.writer or self._own_program
        if self._own is None and message.seq is not None:
            self._own = WriterStream(message.seq, message.stamp, message.arrival_s)
        self._periods.arrive(message.arrival_s, is_restart=is_restart)
        self._birth_s = message.arrival_s - delay.lateness_s(message.delay_s, self.max_age_s)
        return Verdict(accepted=True, utime=message.stamp, birth_s=self._birth_s, reason="", is_restart=is_restart)

    def _rejected(self, message: _Arrived, reason: str, detail: str = "") -> Verdict:
        self.reject(reason, detail, message.arrival_s)
        return Verdict(accepted=False, utime=message.stamp, birth_s=message.arrival_s, reason=reason, is_restart=False)

    def _note(self, fault: str, message: _Arrived) -> None:
        self._fault, self._fault_s = fault, message.arrival_s


def _restart(own: WriterStream, seq: int, message: _Arrived) -> str:
    return (
        f"seq is {seq} after {own.seq}, expected {own.seq + 1}, from the same program, {message.writer}: its driver "
        "has started again, or its message was zeroed"
    )
