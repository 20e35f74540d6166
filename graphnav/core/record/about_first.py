"""Write the description of a run before all other events of a log."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from graphnav.core.codec import DecodeError, decode, encode, fingerprint
from graphnav.core.messages import About
from graphnav.core.record.event import Event
from graphnav.core.record.threaded_writer import Log

WAIT_S = 1.2
"""A run publishes its description once a second."""
_MAX_HELD_BYTES = 32 << 20
_ABOUT = fingerprint(About.lcm_class)


def is_about(channel: str, data: bytes) -> bool:
    """Whether a message describes a run."""
    return channel == About.CHANNEL and data[:8] == _ABOUT


class AboutFirst:
    """Writes the first description of a run before everything else, with the timestamp of the first event.

    Waits for the description for 1.2 s after the first event, or until 32 MB are held back. Without a description the
    events are written as they arrived.

    ``definitions``: of types that the log should decode by itself; they are added to every description of a run.
    Without one, the log begins with a description that holds nothing else.
    """

    def __init__(self, log: Log, now_s: Callable[[], float] = time.monotonic, definitions: str = "") -> None:
        self._log, self._now_s, self._definitions = log, now_s, definitions
        self._n_added = 0
        self._held: list[Event] = []
        self._held_bytes = 0
        self._until_s = 0.0
        self._is_waiting = True

    @property
    def n_events(self) -> int:
        """The number of events, including those held back."""
        return max(0, self._log.n_events - self._n_added) + len(self._held)

    @property
    def last_us(self) -> int | None:
        """The timestamp of the last event that is not held back, None without one."""
        return self._log.last_us

    @property
    def n_bytes(self) -> int:
        """The size of the log, excluding events held back."""
        return self._log.n_bytes

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Append an event, or hold it back; raises LogError if the disk refuses it."""
        if self._held and self._now_s() >= self._until_s:
            self._release()
        if self._definitions and is_about(channel, data):
            data = self._defined(data)
        if not self._is_waiting:
            self._log.write(channel, utime, data)
        elif is_about(channel, data):
            self._held.insert(0, Event(channel, self._held[0].utime if self._held else utime, data))
            self._release()
        else:
            if not self._held:
                self._until_s = self._now_s() + WAIT_S
            self._held.append(Event(channel, utime, data))
            self._held_bytes += len(data)
            if self._held_bytes > _MAX_HELD_BYTES:
                self._release()

    def flush(self) -> None:
        """Hand all events to the kernel, except those held back."""
        if self._held and self._now_s() >= self._until_s:
            self._release()
        self._log.flush()

    def resume(self, room_bytes: int = 0) -> None:
        """Accept events again after a write error; raises LogError if the disk has not ``room_bytes`` for more."""
        self._log.resume(room_bytes)

    def close(self) -> None:
        """Write the events held back, flush and close."""
        try:
            self._release()
        finally:
            self._log.close()

    def _release(self) -> None:
        self._is_waiting = False
        held, self._held = self._held, []
        if self._definitions and held and not is_about(held[0].channel, held[0].data):
            self._n_added = 1
            empty = About(graph_yaml="", lcm_text=self._definitions, run_id="", seed=0, channels=(), types=())
            self._log.write(About.CHANNEL, held[0].utime, encode(empty, held[0].utime, 0))
        for event in held:
            self._log.write(*event)

    def _defined(self, data: bytes) -> bytes:
        """Return a description of a run with the definitions of further types."""
        try:
            utime, seq, about = decode(About, data)
        except DecodeError:
            return data
        return encode(replace(about, lcm_text="\n".join(filter(None, (about.lcm_text, self._definitions)))), utime, seq)
