"""Messages that an end of a tunnel is to send: all while the link takes them, else the newest of each channel."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

_MAX_CHANNELS = 1000
_FRESH_S = 0.2
"""A burst waits so long; then only the newest message of a channel does."""
_MAX_BYTES = 32 << 20
_MAX_MESSAGES = 20_000
"""Of a channel, and of all that wait: bounds memory, whatever is sent."""
_PER_MESSAGE_BYTES = 256
_FRAME_BYTES = 1 << 16
"""A frame is sent when it has so many bytes, and is larger only for a message that is."""
OTHERS = "(further channels)"


@dataclass
class Passed:
    """The messages of a channel in one direction.

    ``passed``, ``n_bytes``: sent, or given to the group. ``dropped``: newer ones were pending, or there was no room.
    ``thinned``: above the rate that the channel is limited to. ``held``: on a motor channel that is not named.
    ``refused``: not for a channel that is chosen, or not accepted by LCM.
    """

    passed: int = 0
    n_bytes: int = 0
    dropped: int = 0
    thinned: int = 0
    held: int = 0
    refused: int = 0

    def add(self, other: Passed) -> None:
        """Add the messages of another time."""
        for name, value in vars(other).items():
            setattr(self, name, getattr(self, name) + value)


class Accounts:
    """The messages of one direction, by channel; those beyond the first 1000 are counted together."""

    def __init__(self) -> None:
        self.channels: dict[str, Passed] = {}

    def of(self, channel: str) -> Passed:
        """Return the account of a channel."""
        found = self.channels.get(channel)
        if found is None:
            name = channel if len(self.channels) < _MAX_CHANNELS else OTHERS
            found = self.channels.setdefault(name, Passed())
        return found

    def add(self, others: Accounts) -> None:
        """Add those of another connection."""
        for channel, passed in others.channels.items():
            self.of(channel).add(passed)


class _Pending:
    """The messages of a channel that wait, with their arrivals, and the one that its rate keeps back."""

    __slots__ = ("account", "due_s", "kept", "period_s", "waiting")

    def __init__(self, account: Passed, limit_hz: float) -> None:
        self.account = account
        self.period_s = 1 / limit_hz
        self.due_s = -math.inf
        self.kept: bytes | None = None
        self.waiting: deque[tuple[float, bytes]] = deque()


class Outbox:
    """Messages by channel, in bounded memory; those of one channel leave in order, and channels take turns."""

    def __init__(self, accounts: Accounts) -> None:
        self._accounts = accounts
        self._pending: dict[str, _Pending] = {}
        self._turns: dict[str, None] = {}
        """The channels with messages that wait, the next one first."""
        self._kept: set[str] = set()
        self._full_s = -math.inf
        self.n_bytes = self.n_messages = 0
        """Of what waits, with what rates keep back."""

    @property
    def has_more(self) -> bool:
        """Whether a message waits."""
        return bool(self._turns)

    def put(self, channel: str, data: bytes, limit_hz: float, now_s: float) -> None:
        """Add a message of a channel that is limited to a rate."""
        pending = self._pending.get(channel)
        if pending is None:
            pending = self._add(channel, limit_hz, now_s)
            if pending is None:
                self._accounts.of(channel).dropped += 1
                return
        if now_s >= pending.due_s and pending.kept is None:
            pending.due_s = now_s + pending.period_s
            self._append(channel, pending, data, now_s)
            return
        if pending.kept is not None:
            self._unkeep(channel, pending)
            pending.account.thinned += 1
        if not self._has_room(data):
            pending.account.dropped += 1
            return
        self._count(data, 1)
        pending.kept = data
        self._kept.add(channel)

    def release(self, now_s: float) -> float:
        """Add what rates have kept back and do no longer; return the time of the next one, infinite for none."""
        next_s = math.inf
        for channel in tuple(self._kept):
            pending = self._pending[channel]
            if now_s < pending.due_s:
                next_s = min(next_s, pending.due_s)
                continue
            data = self._unkeep(channel, pending)
            pending.due_s = max(pending.due_s, now_s - pending.period_s) + pending.period_s
            self._append(channel, pending, data, now_s)
        return next_s

    def take(self, now_s: float) -> tuple[list[str], list[bytes]]:
        """Return channels and messages of the next frame, none if nothing waits."""
        channels: list[str] = []
        messages: list[bytes] = []
        n_bytes = 0
        while self._turns and n_bytes < _FRAME_BYTES:
            channel = next(iter(self._turns))
            pending = self._pending[channel]
            self._drop_old(pending, now_s)
            data = pending.waiting[0][1]
            if messages and n_bytes + len(data) > _FRAME_BYTES:
                break
            self._pop(pending)
            del self._turns[channel]
            if pending.waiting:
                self._turns[channel] = None
            pending.account.passed += 1
            pending.account.n_bytes += len(data)
            n_bytes += len(data) + _PER_MESSAGE_BYTES
            channels.append(channel)
            messages.append(data)
        return channels, messages

    def drop_all(self) -> None:
        """Count what waits as dropped: the link is lost."""
        for pending in self._pending.values():
            pending.account.dropped += len(pending.waiting) + (pending.kept is not None)
        self._pending.clear()
        self._turns.clear()
        self._kept.clear()
        self.n_bytes = self.n_messages = 0

    def _add(self, channel: str, limit_hz: float, now_s: float) -> _Pending | None:
        """Return a new channel; None where there are too many of which something waits."""
        if len(self._pending) >= _MAX_CHANNELS:
            if now_s < self._full_s:
                return None
            self._full_s = now_s + _FRESH_S
            for name in [name for name, one in self._pending.items() if not one.waiting and one.kept is None]:
                del self._pending[name]
            if len(self._pending) >= _MAX_CHANNELS:
                return None
        pending = self._pending[channel] = _Pending(self._accounts.of(channel), limit_hz)
        return pending

    def _append(self, channel: str, pending: _Pending, data: bytes, now_s: float) -> None:
        """Let a message wait, if there is room: for it older ones of its channel are dropped."""
        self._drop_old(pending, now_s, keep=0)
        while pending.waiting and not self._has_room(data):
            self._pop(pending)
            pending.account.dropped += 1
        if self._has_room(data):
            self._count(data, 1)
            pending.waiting.append((now_s, data))
            self._turns.setdefault(channel)
        else:
            self._turns.pop(channel, None)
            pending.account.dropped += 1

    def _has_room(self, data: bytes) -> bool:
        return self.n_bytes + len(data) + _PER_MESSAGE_BYTES <= _MAX_BYTES and self.n_messages < _MAX_MESSAGES

    def _count(self, data: bytes, sign: int) -> None:
        self.n_bytes += sign * (len(data) + _PER_MESSAGE_BYTES)
        self.n_messages += sign

    def _unkeep(self, channel: str, pending: _Pending) -> bytes:
        """Return what the rate of a channel has kept back, and forget it."""
        data, pending.kept = pending.kept, None
        assert data is not None
        self._kept.remove(channel)
        self._count(data, -1)
        return data

    def _drop_old(self, pending: _Pending, now_s: float, keep: int = 1) -> None:
        """Drop what has waited too long; ``keep``: of so many the newest ones, since nothing newer follows."""
        waiting = pending.waiting
        while len(waiting) > keep and now_s - waiting[0][0] > _FRESH_S:
            self._pop(pending)
            pending.account.dropped += 1

    def _pop(self, pending: _Pending) -> None:
        self._count(pending.waiting.popleft()[1], -1)
