"""Count missing messages by their sequence numbers."""

from __future__ import annotations

_MAX_WRITERS = 4
_MAX_GAP = 1_000_000
"""A larger step of the numbers indicates another writer."""


class SequenceGaps:
    """Counts the missing sequence numbers of a channel.

    A number is compared with the nearest smaller one among those of the newest 4 writers, so that alternating writers
    are not counted as losses. Equal numbers are repetitions. A number that is not near any of them restarts the
    count.

    ``lost``: all missing numbers, ``lost_since_restart``: those after the newest restart. ``n_restarts``: -1 before the
    first number.
    """

    __slots__ = ("_before_restart", "_newest", "lost", "n_restarts")

    def __init__(self) -> None:
        self.lost = self._before_restart = 0
        self.n_restarts = -1
        self._newest: list[int] = []

    @property
    def lost_since_restart(self) -> int:
        """The number of missing numbers since the numbering restarted."""
        return self.lost - self._before_restart

    def see(self, seq: int) -> None:
        """Count a message with this number."""
        newest = self._newest
        if newest and newest[0] == seq - 1:
            newest[0] = seq
            return
        below = max((other for other in newest if 0 <= seq - other <= _MAX_GAP), default=None)
        if below is None:
            self.n_restarts += 1
            self._before_restart = self.lost
            del newest[_MAX_WRITERS - 1 :]
        else:
            self.lost += max(0, seq - below - 1)
            newest.remove(below)
        newest.insert(0, seq)
