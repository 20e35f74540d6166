"""Read an input of a live run: decode and check its messages, count the rejected ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from graphnav.adapter import Adapter
from graphnav.codec import DecodeError, codec_of, fingerprint
from graphnav.errors import one_line
from graphnav.graph import InputChannel
from graphnav.interrupts import USER_ENDS
from graphnav.live.clock import LiveClock
from graphnav.live.inputs.receiver import Arrival, Mailbox
from graphnav.live.inputs.sender_monitor import SenderMonitor, Verdict
from graphnav.messages import Message
from graphnav.motors.channel import INT64_BYTES
from graphnav.motors.offsets import offsets_of

NEWEST = 8
"""Maximum number of pending messages if only the newest counts: images of 640x480 have 0.3 to 0.9 MB."""
GATHERED = 1024
"""Maximum number of pending messages if every one counts."""
FLOOD = "flood"
"""Reason for messages of a second writer that are too many to be judged one by one."""


class Received(NamedTuple):
    """A message to deliver; ``raw``: its bytes if they encode the message itself."""

    utime: int
    message: Message
    birth_s: float
    raw: bytes | None
    is_restart: bool


class Intake:
    """Takes the messages of one input from its mailbox.

    ``needs_all``: whether every message counts, as for `Since` inputs and joins; else only the newest is decoded.
    """

    def __init__(self, source: InputChannel, clock: LiveClock, *, needs_all: bool) -> None:
        self.source = source
        self.monitor = SenderMonitor(source.max_age_s)
        self.mailbox = Mailbox(fingerprint(source.lcm_class), GATHERED if needs_all else NEWEST, self._is_own)
        self.needs_all = needs_all
        self.used = 0
        """Number of delivered messages."""
        self.heard_s = -math.inf
        """Arrival of the last delivered message, monotonic seconds."""
        self.last_error = ""
        """Error of the last message that could not be read."""
        self.overtaken = 0
        """Number of valid messages that were older than the newest."""
        self._clock = clock
        self._codec = codec_of(source.lcm_class)
        self._sizes: tuple[tuple[int, ...], ...] | None = None
        self._seq_at = None if source.channel.message.many_writers else offsets_of(source.lcm_class)[1]
        self._seen_wrong = self._seen_overflowed = self._seen_flooded = 0
        self._overflowed_before: int | None = None
        """Messages that the mailbox had dropped when the first one was judged: their numbers are not missed."""
        self._birth_s = -math.inf

    def take(self) -> Iterator[Received]:
        """Yield valid messages, oldest first; count the others."""
        accepted: list[tuple[Arrival, Mapping[str, Any], Verdict]] = []
        for arrival in self.mailbox.take():
            judged = self._judge(arrival)
            if judged is not None:
                accepted.append((arrival, *judged))
        self._count_unread()
        if self.needs_all:
            for arrival, fields, verdict in accepted:
                message = self._message(fields)
                if message is not None:
                    yield self._received(arrival, message, verdict, is_restart=verdict.is_restart)
            return
        is_restart = any(verdict.is_restart for _, _, verdict in accepted)
        for place in range(len(accepted) - 1, -1, -1):
            arrival, fields, verdict = accepted[place]
            message = self._message(fields)
            if message is not None:
                self.overtaken += place
                yield self._received(arrival, message, verdict, is_restart=is_restart)
                return

    @property
    def lost(self) -> int:
        """Messages that never arrived, by their sequence numbers; overtaken messages did arrive."""
        return max(0, self.monitor.missing - (self.mailbox.overflowed - (self._overflowed_before or 0)))

    def age_s(self, now_s: float) -> float:
        """Return the age of the newest delivered message, infinite before the first."""
        return now_s - self._birth_s

    def _judge(self, arrival: Arrival) -> tuple[Mapping[str, Any], Verdict] | None:
        try:
            fields = self._codec.decode(arrival.data)
        except DecodeError:
            self.monitor.reject("undecodable")
            return None
        adapter = self.source.adapter
        utime = self._adapted_utime(adapter, fields) if adapter is not None else fields.get("utime")
        seq = fields.get("seq")
        if self._overflowed_before is None:
            self._overflowed_before = self.mailbox.overflowed
        if self.source.channel.message.many_writers:
            utime = seq = None
        verdict = self.monitor.judge(
            arrival.at_s,
            self._clock.utime_at(arrival.at_s),
            utime if isinstance(utime, int) else None,
            seq if isinstance(seq, int) else None,
        )
        return (fields, verdict) if verdict.accepted else None

    def _adapted_utime(self, adapter: Adapter, fields: Mapping[str, Any]) -> int | None:
        """Return the sender's timestamp, None if there is none or the adapter cannot read it."""
        try:
            return adapter.utime(fields)
        except USER_ENDS:
            raise
        except BaseException as error:  # noqa: BLE001 - third-party adapter, untrusted bytes
            self.last_error = one_line(error)
            return None

    def _message(self, fields: Mapping[str, Any]) -> Message | None:
        """Return the message of decoded fields, None if it is not valid."""
        source = self.source
        try:
            if source.adapter is not None:
                message = source.adapter.from_lcm(fields)
            else:
                message = source.channel.message.from_lcm_fields(fields)
            not_finite = message.not_finite()
        except USER_ENDS:
            raise
        except BaseException as error:  # noqa: BLE001 - third-party adapter, untrusted bytes
            self.last_error = one_line(error)
            self.monitor.reject("unreadable")
            return None
        if not_finite:
            self.monitor.reject("not finite")
            return None
        sizes = tuple(np.shape(getattr(message, name)) for name in message.grid)
        if any(0 in size for size in sizes) or getattr(message, "step_px", 1) < 1:
            self.monitor.reject("empty")
            return None
        if self._sizes is None:
            self._sizes = sizes
        elif sizes != self._sizes:
            self.monitor.reject("wrong size")
            return None
        return message

    def _received(self, arrival: Arrival, message: Message, verdict: Verdict, *, is_restart: bool) -> Received:
        self._birth_s, self.heard_s = verdict.birth_s, arrival.at_s
        self.used += 1
        raw = arrival.data if self.source.adapter is None else None
        return Received(verdict.utime, message, verdict.birth_s, raw, is_restart)

    def _is_own(self, data: bytes, at_s: float) -> bool:
        """Whether a message may be from the accepted writer; called by the receive thread."""
        if self._seq_at is None or len(data) < self._seq_at + INT64_BYTES:
            return True
        seq = int.from_bytes(data[self._seq_at : self._seq_at + INT64_BYTES], "big", signed=True)
        return self.monitor.may_be_own(seq, at_s)

    def _count_unread(self) -> None:
        """Count messages that were never taken from the mailbox."""
        wrong, overflowed, flooded = self.mailbox.wrong_type, self.mailbox.overflowed, self.mailbox.flooded
        if flooded > self._seen_flooded:
            self.monitor.rejected[FLOOD] += flooded - self._seen_flooded
        if wrong > self._seen_wrong:
            self.monitor.rejected["wrong type"] += wrong - self._seen_wrong
        self.overtaken += overflowed - self._seen_overflowed
        self._seen_wrong, self._seen_overflowed, self._seen_flooded = wrong, overflowed, flooded
