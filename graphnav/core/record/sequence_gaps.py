"""Count missing messages by their sequence numbers."""

from __future__ import annotations

from graphnav.core.codec import fields_of, fingerprint, known_types

_SEQ_AT = slice(16, 24)
"""After the fingerprint and ``utime``."""
_MAX_WRITERS = 4
_MAX_GAP = 1_000_000
"""A larger step of the numbers indicates another writer."""


def numbered_fingerprints() -> frozenset[bytes]:
    """Return the fingerprints of the known types whose messages begin with ``utime`` and ``seq``."""
    found = []
    for lcm_class in known_types():
        first = [(field.name, field.primitive, field.dims) for field in fields_of(lcm_class)[:2]]
        if first == [("utime", "int64_t", ()), ("seq", "int64_t", ())]:
            found.append(fingerprint(lcm_class))
    return frozenset(found)


def seq_of(data: bytes) -> int | None:
    """Return the sequence number of a message of a numbered type, None if the message is too short."""
    return int.from_bytes(data[_SEQ_AT], "big", signed=True) if len(data) >= _SEQ_AT.stop else None


class SequenceGaps:
    """Counts the missing sequence numbers of a channel.

    A number is compared with the nearest smaller one among those of the newest 4 writers, so that alternating writers
    are not counted as losses. Equal numbers are repetitions. A number that is not near any of them restarts the
    count.
    """

    __slots__ = ("_newest", "lost", "n_restarts")

    def __init__(self) -> None:
        self.lost = 0
        self.n_restarts = -1
        self._newest: list[int] = []

    def see(self, seq: int) -> None:
        """Count a message with this number."""
        newest = self._newest
        if newest and newest[0] == seq - 1:
            newest[0] = seq
            return
        below = max((other for other in newest if 0 <= seq - other <= _MAX_GAP), default=None)
        if below is None:
            self.n_restarts += 1
            del newest[_MAX_WRITERS - 1 :]
        else:
            self.lost += max(0, seq - below - 1)
            newest.remove(below)
        newest.insert(0, seq)
