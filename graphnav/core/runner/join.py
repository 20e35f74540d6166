"""Join the messages of several plain inputs by their stamps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

MAX_UNMATCHED = 8


@dataclass(frozen=True)
class Held:
    """A pending message; ``birth_s``: the arrival of the input that it derives from, monotonic seconds.

    ``number``: index of the message in its channel, from 0.
    """

    message: Any
    birth_s: float
    arrived_s: float
    number: int = 0


@dataclass(frozen=True)
class MatchedSet:
    """A complete set of plain inputs, by port; ``ready_s``: arrival of its last message."""

    utime: int
    held: Mapping[str, Held]
    ready_s: float

    @cached_property
    def birth_s(self) -> float:
        """The oldest birth in the set."""
        return min(held.birth_s for held in self.held.values())


class Join:
    """Holds the messages of a stage's plain inputs until they match.

    Branches of a graph differ in latency, so each port holds unmatched stamps, at most ``max_unmatched`` (None: no
    limit). Without ``in_order`` the newest complete set is taken and everything older is overtaken; with it every
    complete set is taken, oldest first, and only messages that can no longer be matched are overtaken.
    """

    def __init__(
        self, ports: Iterable[str], *, max_unmatched: int | None = MAX_UNMATCHED, in_order: bool = False
    ) -> None:
        self._waiting: dict[str, dict[int, Held]] = {port: {} for port in ports}
        self._max = max_unmatched
        self.in_order = in_order
        self.overtaken: Counter[str] = Counter()
        """Dropped messages by port."""
        self.unmatched: Counter[str] = Counter(dict.fromkeys(self._waiting, 0))
        """Messages by port since the last complete set."""

    def adopt(self, before: Join, ports: Collection[str]) -> None:
        """Take the pending messages of some ports from another join, and all of its counts."""
        for port in ports:
            self._waiting[port] = before._waiting[port]
        self.overtaken = before.overtaken

    @property
    def never_matches(self) -> bool:
        """Whether no set is complete although each of several ports got as many messages as it holds by default."""
        many = len(self.unmatched) > 1 and min(self.unmatched.values()) >= MAX_UNMATCHED
        return many and not self.complete()

    def put(self, port: str, utime: int, held: Held) -> None:
        """Add a message."""
        waiting = self._waiting[port]
        waiting[utime] = held
        self.unmatched[port] += 1
        if self._max is not None and len(waiting) > self._max:
            del waiting[min(waiting)]
            self.overtaken[port] += 1

    def complete(self) -> list[int]:
        """Return the stamps of the complete sets in the order in which they are taken."""
        if not self._waiting or not all(self._waiting.values()):
            return []
        stamps = set.intersection(*map(set, self._waiting.values()))
        return sorted(stamps, reverse=not self.in_order)

    def peek(self, utime: int) -> MatchedSet:
        """Return a complete set."""
        held = {port: waiting[utime] for port, waiting in self._waiting.items()}
        return MatchedSet(utime, held, max(one.arrived_s for one in held.values()))

    def take(self, utime: int) -> MatchedSet:
        """Remove and return a complete set; drop everything older."""
        matched = self.peek(utime)
        for port, waiting in self._waiting.items():
            self.unmatched[port] = 0
            older = [stamp for stamp in waiting if stamp <= utime]
            for stamp in older:
                del waiting[stamp]
            self.overtaken[port] += len(older) - 1
        return matched

    def newest_allowed(self, allowed: Callable[[MatchedSet], bool]) -> MatchedSet | None:
        """Return, without removing it, the first complete set that ``allowed`` accepts."""
        return next((one for utime in self.complete() if allowed(one := self.peek(utime))), None)

    def gap_us(self) -> int:
        """Return the smallest difference of two stamps that wait on different ports; 0 if fewer than two ports wait."""
        ports = [sorted(waiting) for waiting in self._waiting.values() if waiting]
        return min((abs(a - b) for one, other in combinations(ports, 2) for a in one for b in other), default=0)

    @property
    def n_waiting(self) -> int:
        """Number of pending messages."""
        return sum(map(len, self._waiting.values()))

    def clear(self) -> None:
        """Drop pending messages without counting them: their stamps have become meaningless."""
        self.unmatched = Counter(dict.fromkeys(self._waiting, 0))
        for waiting in self._waiting.values():
            waiting.clear()
