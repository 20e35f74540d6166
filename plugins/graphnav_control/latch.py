"""Hold the robot after a fault that shows only while it moves."""

from __future__ import annotations

from collections import deque
from enum import Enum

RETRY_AFTER_US = 1_000_000
"""Time that the robot stands before it retries by itself."""
RETRY_S = 1.0
"""Shortest time of a retry: its speed is the distance by this."""
MAX_RETRIES = 5
"""Maximum number of retries in vain: a slow heartbeat that arms, or a picture that flickers, must not drive a robot."""
MAX_RELAPSES = 4
RELAPSES_US = 20_000_000
"""So many faults within this time hold the robot for good."""


class _State(Enum):
    FREE = "the input is trusted"
    STANDING = "the robot stands"
    RETRYING = "the robot drives a short distance to see whether the input follows"


class Latch:
    """Holds the robot after a fault that shows only while it moves.

    A robot that stands shows no such fault, so that without memory it would drive on, in pulses, until it hits
    something. Here it stands for a second after the fault, then retries by itself, once: at most ``retry_m``, slowly.
    If the input follows the motion meanwhile, it is trusted again, and all is as before the fault. If not, the robot
    stands for good, it is latched. A further retry, again of at most ``retry_m``, takes something new: a person who
    arms the guard, or a picture that changed; after 5 in vain there are no more. Where an operator drives, the input is
    trusted again only if it followed. An input that was never seen to follow is not retried by itself.
    """

    def __init__(self, retry_m: float) -> None:
        self._retry_m = retry_m
        self._left_m = 0.0
        self._state = _State.FREE
        self._n_retries = 0
        self._retries_itself = True
        self._since = 0

    @property
    def is_free(self) -> bool:
        """Whether the input is trusted."""
        return self._state is _State.FREE

    @property
    def is_retrying(self) -> bool:
        """Whether the robot retries; at most `speed_mps`."""
        return self._state is _State.RETRYING

    @property
    def is_latched(self) -> bool:
        """Whether the robot stands until something new comes."""
        return self._state is _State.STANDING and not self._retries_itself

    @property
    def speed_mps(self) -> float:
        """The maximum speed of a retry."""
        return self._retry_m / RETRY_S

    def update(
        self, utime: int, retried_m: float, *, is_faulty: bool, is_proven: bool, is_new: bool, is_known: bool = True
    ) -> bool:
        """Go on by one firing; return whether the state changed.

        ``retried_m``: driven by the last command, not by an operator. ``is_faulty``: the fault shows. ``is_proven``:
        the input has followed the robot. ``is_new``: the guard was armed, or the picture changed. ``is_known``: the
        input has followed the robot at some time before.
        """
        before = self._state
        if is_proven:
            self._state, self._n_retries = _State.FREE, 0
        elif self._state is _State.RETRYING:
            self._left_m -= retried_m
            if is_faulty or self._left_m <= retried_m:
                self._state, self._since = _State.STANDING, utime
        elif is_faulty:
            self._state, self._since = _State.STANDING, utime
        elif self._state is _State.STANDING:
            waited = utime - self._since >= RETRY_AFTER_US
            if self._n_retries < MAX_RETRIES and (is_new or (waited and self._retries_itself)):
                self._state, self._left_m = _State.RETRYING, self._retry_m
                self._n_retries += 1
        self._retries_itself = is_known and not self._n_retries
        return self._state is not before


class Relapses:
    """Holds the robot for a second after each fault, and for good after four of them within 20 s.

    For faults that go away when the robot stands and need not come back when it drives on, as a floor that repeats and
    is confusing only where it is driven over fast. For good is until a person arms the guard or drives.
    """

    def __init__(self) -> None:
        self._begun: deque[int] = deque(maxlen=MAX_RELAPSES)
        self._since: int | None = None
        self.is_latched = False

    @property
    def is_free(self) -> bool:
        """Whether the robot may drive."""
        return self._since is None and not self.is_latched

    def update(self, utime: int, *, is_faulty: bool, is_new: bool) -> None:
        """Go on by one firing; ``is_new``: a person armed the guard, or drives."""
        if is_new:
            self._begun.clear()
            self.is_latched = False
        if is_faulty:
            if self._since is None:
                self._begun.append(utime)
                self.is_latched |= len(self._begun) == MAX_RELAPSES and utime - self._begun[0] <= RELAPSES_US
            self._since = utime
        elif self._since is not None and utime - self._since >= RETRY_AFTER_US:
            self._since = None
