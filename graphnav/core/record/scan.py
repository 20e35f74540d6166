"""Find the events of a log, including those after damaged bytes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from graphnav.core.errors import LogError
from graphnav.core.record.event import HEADER, SYNC, Damaged, Entry, LogFile, TruncatedEvent

_SYNC_WORD = SYNC.to_bytes(4, "big")
_MAX_CHANNEL_BYTES = 1000
_HEAD_BYTES = HEADER.size + 63
_BLOCK_BYTES = 1 << 16
_NEAR_BYTES = 1 << 12
"""Events smaller than this are read in blocks."""
_SEARCH_BYTES = 1 << 20


class _Found(NamedTuple):
    """A candidate event: its position, its number in the log, and its content."""

    begin: int
    number: int
    entry: Entry


def scan(path: Path, file: LogFile) -> Iterator[Entry | Damaged | TruncatedEvent]:
    """Yield the events of a log in file order, and the damage between them.

    Damage is skipped up to the next event that is followed by another event or by the end of the file, or that has a
    plausible number. An event with a damaged length does not end where another one begins and is skipped. A log that
    ends within an event yields a `TruncatedEvent` last.

    Raises LogError if the file is not empty and no event begins in it.
    """
    reader = _Reader(file)
    at, last, n_events = 0, None, 0
    while at < file.size:
        found = reader.event_at(at)
        if found is None:
            begin, resumed = _around(reader, last, at)
            if last is not None and begin == at:
                yield last.entry
                n_events += 1
            last = None
            if resumed is None:
                yield _rest(path, reader, begin, n_events)
                return
            yield Damaged(begin, resumed.begin - begin)
            found = resumed
        if last is not None:
            yield last.entry
            n_events += 1
        last, at = found, found.entry.stop
    if last is not None:
        yield last.entry


def _around(reader: _Reader, last: _Found | None, at: int) -> tuple[int, _Found | None]:
    """Return where the damage at ``at`` begins and the first event after it, None if there is none.

    It begins at the preceding event ``last`` if the length of that event is implausible.
    """
    if last is None:
        return at, reader.next_event(at + 1, reader.size, None)
    for candidate in reader.candidates(last.begin + 1, at):
        if candidate.number == last.number + 1:
            return last.begin, candidate
    resumed = reader.next_event(at, reader.size, last)
    is_next = resumed is not None and resumed.number == last.number + 1
    return (last.begin if is_next else at), resumed


def _rest(path: Path, reader: _Reader, begin: int, n_events: int) -> Damaged | TruncatedEvent:
    """Return the damage or the truncated event at the end of a log."""
    if reader.begins_event(begin):
        return TruncatedEvent(begin, reader.size - begin)
    if not n_events and not begin:
        raise LogError(f"{path} is not an LCM log")
    return Damaged(begin, reader.size - begin)


class _Reader:
    """Reads candidate events; consecutive small events are read from one block."""

    def __init__(self, file: LogFile) -> None:
        self.size = file.size
        self._file = file
        self._begin = 0
        self._block = b""

    def event_at(self, at: int) -> _Found | None:
        """Return the event that begins at ``at`` and ends within the file, None if there is none."""
        head = self._read(at, _HEAD_BYTES)
        if len(head) < HEADER.size:
            return None
        sync, number, utime, channel_bytes, data_bytes = HEADER.unpack_from(head)
        if sync != SYNC or not 0 < channel_bytes <= _MAX_CHANNEL_BYTES or data_bytes < 0:
            return None
        start = at + HEADER.size + channel_bytes
        if start + data_bytes > self.size:
            return None
        if HEADER.size + channel_bytes > len(head):
            head = self._file.read(at, start)
        channel = head[HEADER.size : HEADER.size + channel_bytes].decode("utf-8", "replace")
        return _Found(at, number, Entry(channel, utime, start, start + data_bytes))

    def begins_event(self, at: int) -> bool:
        """Whether the bytes from ``at`` to the end of the file can be the beginning of an event."""
        head = self._read(at, HEADER.size)
        if len(head) < HEADER.size:
            return head[:4] == _SYNC_WORD[: len(head)]
        sync, _, _, channel_bytes, data_bytes = HEADER.unpack_from(head)
        return bool(sync == SYNC and 0 < channel_bytes <= _MAX_CHANNEL_BYTES and data_bytes >= 0)

    def next_event(self, start: int, stop: int, last: _Found | None) -> _Found | None:
        """Return the first event that begins in a range and can be trusted, None if there is none."""
        return next((found for found in self.candidates(start, stop) if self._is_event(found, last)), None)

    def candidates(self, start: int, stop: int) -> Iterator[_Found]:
        """Yield the candidate events that begin in a range."""
        while start < stop:
            block = self._file.read(start, min(start + _SEARCH_BYTES, stop + 3))
            at = block.find(_SYNC_WORD)
            while at >= 0:
                if (found := self.event_at(start + at)) is not None:
                    yield found
                at = block.find(_SYNC_WORD, at + 1)
            start += max(1, len(block) - 3)

    def _is_event(self, found: _Found, last: _Found | None) -> bool:
        """Whether another event or the end follows, or the number is plausible at this distance after ``last``."""
        stop = found.entry.stop
        follows = self._read(stop, 4)
        if follows == _SYNC_WORD[: len(follows)] and (len(follows) == 4 or stop + len(follows) == self.size):
            return True
        if last is None:
            return False
        return 0 < found.number - last.number <= 1 + (found.begin - last.begin) // HEADER.size

    def _read(self, start: int, n_bytes: int) -> bytes:
        """Return bytes, fewer at the end of the file."""
        offset = start - self._begin
        if offset >= 0 and offset + n_bytes <= len(self._block):
            return self._block[offset : offset + n_bytes]
        is_near = 0 <= offset < len(self._block) + _NEAR_BYTES
        self._begin = start
        self._block = self._file.read(start, start + (_BLOCK_BYTES if is_near else n_bytes))
        return self._block[:n_bytes]
