"""Count missing messages by their sequence numbers."""

from __future__ import annotations

from typing import NamedTuple

_MAX_WRITERS = 4
_MAX_GAP = 1_000_000
"""A larger step of the numbers indicates another writer."""
_MAX_LATE = 8
"""How many numbers after a gap one within it may still come late, or from another writer."""


class _Gap(NamedTuple):
    before: int
    after: int

    @property
    def n_missing(self) -> int:
        return self.after - self.before - 1


class SequenceGaps:
    """Counts the missing sequence numbers of a channel.

    A number is compared with the nearest smaller one among those of the newest 4 writers, so that alternating writers
    are not counted as losses. One within a recent gap shows that the gap was another writer, or two messages in the
    wrong order: then nothing of it is missing. Equal numbers are repetitions. A number that is not near any of them
    restarts the count.

    ``lost``: all missing numbers, ``lost_since_restart``: those after the newest restart. ``n_restarts``: -1 before the
    first number.
    """

    __slots__ = ("_before_restart", "_gaps", "_newest", "lost", "n_restarts")

    def __init__(self) -> None:
        self.lost = self._before_restart = 0
        self.n_restarts = -1
        self._newest: list[int] = []
        self._gaps: list[_Gap] = []

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
        gap = self._gap_of(seq) if self._gaps else None
        if gap is not None and (below is None or below < gap.before):
            self._gaps.remove(gap)
            self.lost += seq - gap.before - 1 - gap.n_missing
            del newest[_MAX_WRITERS - 1 :]
        elif below is None:
            self.n_restarts += 1
            self._before_restart = self.lost
            self._gaps.clear()
            del newest[_MAX_WRITERS - 1 :]
        else:
            newest.remove(below)
            if seq > below + 1:
                self.lost += seq - below - 1
                self._gaps = [*self._gaps[1 - _MAX_WRITERS :], _Gap(below, seq)]
        newest.insert(0, seq)

    def _gap_of(self, seq: int) -> _Gap | None:
        """Return the recent gap that a number lies in, None without one."""
        newest, found = list(self._newest), None
        for gap in reversed(self._gaps):
            if any(0 <= other - gap.after <= _MAX_LATE for other in newest):
                newest.append(gap.before)  # the writer before, if the gap was another one
                if gap.before < seq < gap.after:
                    found = gap if found is None else max(found, gap)
        return found
