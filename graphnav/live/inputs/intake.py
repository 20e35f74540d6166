"""Read an input of a live run: decode and check its messages, count the rejected ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from graphnav import FieldError, Message
from graphnav.core.codec import DecodeError, fields_of, lcm_name, type_of
from graphnav.core.errors import failure_line
from graphnav.core.graph import InputChannel
from graphnav.core.interrupts import CtrlC
from graphnav.live.clock import LiveClock
from graphnav.live.inputs.packet_sources import PacketSources
from graphnav.live.inputs.receiver import NEWEST, Arrival, Mailbox
from graphnav.live.inputs.sender_monitor import SenderMonitor, Verdict
from graphnav.live.inputs.topic_receiver import TopicReceiver
from graphnav.live.motors.channel import INT64_BYTES
from graphnav.live.motors.offsets import offsets_of

GATHERED = 1024
"""Maximum number of pending messages if every one counts."""
FLOOD, WRONG_TYPE, UNDECODABLE, UNREADABLE = "flood", "wrong type", "undecodable", "unreadable"
NOT_FINITE, WRONG_SIZE = "not finite", "wrong size"
"""Reasons of rejections; ``FLOOD``: messages of a second writer that are too many to be judged one by one."""
_AXES = "rows", "cols", "channels"
"""The axes of a grid, first to last."""


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
        self._codec = source.codec
        self.mailbox = Mailbox(self._codec.fingerprint, GATHERED if needs_all else NEWEST, self._is_own)
        self.needs_all = needs_all
        self.used = 0
        """Number of delivered messages."""
        self.overtaken = 0
        """Number of valid messages that were older than the newest."""
        self.sources: PacketSources | TopicReceiver | None = None
        """Where its messages come from, if that is known."""
        self._clock = clock
        self._sizes: tuple[tuple[int, ...], ...] | None = None
        self._step_px = 1
        is_numbered = source.ros_type is None and not source.channel.message.many_writers
        self._seq_at = offsets_of(source.lcm_class)[1] if is_numbered else None
        self._seen_wrong = self._seen_overflowed = self._seen_flooded = 0
        self._overflowed_before: int | None = None
        """Messages that the mailbox had dropped when the first one was judged: their numbers are not missed."""
        self._birth_s = -math.inf

    def take(self) -> Iterator[Received]:
        """Yield valid messages, oldest first; count the others."""
        self._count_unread()
        accepted: list[tuple[Arrival, Mapping[str, Any], Verdict]] = []
        for arrival in self.mailbox.take():
            judged = self._judge(arrival)
            if judged is not None:
                accepted.append((arrival, *judged))
        if self.needs_all:
            for arrival, fields, verdict in accepted:
                message = self._message(fields, arrival.at_s)
                if message is not None:
                    yield self._received(arrival, message, verdict, is_restart=verdict.is_restart)
            return
        is_restart = any(verdict.is_restart for _, _, verdict in accepted)
        for place in range(len(accepted) - 1, -1, -1):
            arrival, fields, verdict = accepted[place]
            message = self._message(fields, arrival.at_s)
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
        except DecodeError as error:
            self.monitor.unread += 1
            self.monitor.reject(UNDECODABLE, str(error), arrival.at_s)
            return None
        if self._overflowed_before is None:
            self._overflowed_before = self.mailbox.overflowed
        utime = seq = None
        if not self.source.channel.message.many_writers:
            try:
                utime, seq = self._utime(fields), fields.get("seq")
            except CtrlC:
                raise
            except BaseException as error:  # noqa: BLE001 - third-party adapter, untrusted bytes
                self.monitor.unread += 1
                self.monitor.reject(UNREADABLE, f"utime: {failure_line(error)}", arrival.at_s)
                return None
        verdict = self.monitor.judge(
            arrival.at_s,
            self._clock.utime_at(arrival.at_s),
            utime,
            seq if isinstance(seq, int) else None,
            *self._writers(arrival.at_s),
        )
        return (fields, verdict) if verdict.accepted else None

    def _writers(self, at_s: float) -> tuple[Sequence[str], str]:
        """Return the programs that sent on the channel lately, and the sender of a message, where they are known."""
        if self.sources is None or self.source.channel.message.many_writers:
            return (), ""
        name, since_s = self.source.name, at_s - self.monitor.max_age_s
        return self.sources.writers(name, since_s), self.sources.sender(name, since_s, at_s)

    def _utime(self, fields: Mapping[str, Any]) -> int | None:
        """Return the sender's timestamp, None if the type has none; raises whatever an adapter raises."""
        adapter = self.source.adapter
        utime = fields.get("utime") if adapter is None else adapter.utime(fields)
        return utime if isinstance(utime, int) else None

    def _message(self, fields: Mapping[str, Any], at_s: float) -> Message | None:
        """Return the message of decoded fields, None if it is not valid."""
        source = self.source
        kind, rejection = source.type_name.rpartition(".")[2], None
        try:
            if source.adapter is None:
                message = source.channel.message.from_lcm_fields(fields)
            else:
                message = source.adapter.read(fields)
                kind = type(message).__name__
            rejection = self._rejection(message)
        except CtrlC:
            raise
        except BaseException as error:  # noqa: BLE001 - third-party adapter, untrusted bytes
            rejection = UNREADABLE, error
        if rejection is not None:
            reason, cause = rejection
            self.monitor.reject(reason, f"{kind}: {failure_line(cause)}", at_s)
            return None
        return message

    def _rejection(self, message: Message) -> tuple[str, BaseException] | None:
        """Return why a message is not used: a value is not finite, a grid is empty or not as in the first one."""
        if (name := message.not_finite()) is not None:
            return NOT_FINITE, _not_finite(name, getattr(message, name))
        sizes = tuple(np.shape(getattr(message, name)) for name in message.grid)
        for name, size in zip(message.grid, sizes, strict=True):
            if 0 in size:
                dims = {field.name: field.dims for field in fields_of(message.lcm_class)}.get(name, _AXES)
                return UNREADABLE, FieldError(str(dims[size.index(0)]), 0, "1 or more")
        if (step_px := getattr(message, "step_px", 1)) < 1:
            return UNREADABLE, FieldError("step_px", step_px, "1 or more; 0 counts as 1")
        if self._sizes is None:
            self._sizes, self._step_px = sizes, step_px
        for size, first in zip(sizes, self._sizes, strict=True):
            if size != first:
                named, found, expected = (" x ".join(map(str, one)) for one in (_AXES[: len(size)], size, first))
                return WRONG_SIZE, FieldError(named, found, f"{expected}, as in the first message")
        if step_px != self._step_px:
            return WRONG_SIZE, FieldError("step_px", step_px, f"{self._step_px}, as in the first message")
        return None

    def _received(self, arrival: Arrival, message: Message, verdict: Verdict, *, is_restart: bool) -> Received:
        self._birth_s = verdict.birth_s
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
            self.monitor.reject(FLOOD, count=flooded - self._seen_flooded)
        if wrong > self._seen_wrong:
            self.monitor.unread += wrong - self._seen_wrong
            self.monitor.reject(WRONG_TYPE, self._wrong_type(), self.mailbox.heard_s, wrong - self._seen_wrong)
        self.overtaken += overflowed - self._seen_overflowed
        self._seen_wrong, self._seen_overflowed, self._seen_flooded = wrong, overflowed, flooded

    def _wrong_type(self) -> str:
        """Return the type of the last message of a wrong one, and what is expected."""
        mark, expected = self.mailbox.wrong_mark, self.source.type_name
        if len(mark) < len(self._codec.fingerprint):
            return f"{len(mark)} bytes, shorter than the fingerprint of {expected}"
        if (found := type_of(mark)) is not None:
            return f"the messages are {lcm_name(found)}, expected {expected}"
        return (
            f"the fingerprint {mark.hex()} is not of an installed type, expected {self._codec.fingerprint.hex()} of "
            f"{expected}: names, types or order of the fields in the .lcm differ"
        )


def _not_finite(name: str, value: Any) -> FieldError:
    """Return the error that names the first element of a field that is not finite."""
    array = np.asarray(value)
    at = tuple(int(index) for index in np.argwhere(~np.isfinite(array))[0])
    shown = f"{name}[{', '.join(map(str, at))}]" if at else name
    return FieldError(shown, array[at], "a finite number")
