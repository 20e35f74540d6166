"""Track the runs announced on ``graphnav.about``."""

from __future__ import annotations

from dataclasses import dataclass

from graphnav.core.codec import DecodeError, decode
from graphnav.core.messages import About
from graphnav.watch.spy import Received

_MAX_RUNS = 16
_MAX_BYTES = 1 << 20
_SILENT_S = 3.5
"""A run, which announces itself every second, is silent after this time without an announcement."""
_ENVELOPE_BYTES = 24


@dataclass
class Announcement:
    """The announcement of a run; ``begin_s``, ``received_s``: its first and last arrival."""

    about: About
    begin_s: float
    received_s: float


class Announcements:
    """The newest announcements of the newest 16 runs."""

    def __init__(self) -> None:
        self.runs: dict[str, Announcement] = {}
        self.refused = 0
        self._bodies: dict[bytes, str] = {}

    def receive(self, received: Received) -> About | None:
        """Process an announcement; return it if it is new or changed."""
        body = received.data[_ENVELOPE_BYTES:]
        run_id = self._bodies.get(body)
        if run_id is not None and run_id in self.runs:
            self.runs[run_id].received_s = received.at_s
            return None
        about = _about(received.data) if len(body) <= _MAX_BYTES else None
        if about is None:
            self.refused += 1
            return None
        known = self.runs.pop(about.run_id, None)
        self.runs[about.run_id] = Announcement(about, known.begin_s if known else received.at_s, received.at_s)
        self._bodies = {old: of for old, of in self._bodies.items() if of in self.runs and of != about.run_id}
        self._bodies[body] = about.run_id
        while len(self.runs) > _MAX_RUNS:
            del self.runs[min(self.runs, key=lambda one: self.runs[one].received_s)]
        return about

    def shown(self, chosen: str | None, now_s: float) -> str | None:
        """Return the run to show: the selected one while it is announced, else the newest; None without runs."""
        alive = [run_id for run_id, one in self.runs.items() if now_s - one.received_s < _SILENT_S]
        if chosen in alive:
            return chosen
        if alive:
            return max(alive, key=lambda run_id: self.runs[run_id].begin_s)
        return max(self.runs, key=lambda run_id: self.runs[run_id].received_s, default=None)


def _about(data: bytes) -> About | None:
    try:
        return decode(About, data)[2]
    except DecodeError:
        return None
