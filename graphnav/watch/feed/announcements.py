"""Track the runs announced on ``graphnav.about``."""

from __future__ import annotations

from dataclasses import dataclass

from graphnav import About
from graphnav.core.codec import DecodeError, decode
from graphnav.core.record import silent_after_s
from graphnav.watch.feed.feed import Received

MAX_RUNS = 32
RUN_SILENT_S = silent_after_s(1.0)
"""A run, which announces itself and sends its status every second, has ended after this time without either."""
_MAX_BYTES = 1 << 20
_ENVELOPE_BYTES = 24


@dataclass
class Announcement:
    """The announcement of a run; ``begin_s``, ``received_s``: its first and last arrival."""

    about: About
    begin_s: float
    received_s: float


class Announcements:
    """The newest announcements of the newest 32 runs, by run id; ``has_forgotten``: whether there were more.

    The id is empty for a run of a version that gave none, and not among ``ids``. ``refused``: messages that are not
    announcements.
    """

    def __init__(self) -> None:
        self.runs: dict[str, Announcement] = {}
        self.refused = 0
        self.has_forgotten = False
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
        if not about.run_id and not about.channels and not about.graph_yaml:
            return None  # definitions of types only
        known = self.runs.get(about.run_id)
        self.runs[about.run_id] = Announcement(about, known.begin_s if known else received.at_s, received.at_s)
        self._bodies = {old: of for old, of in self._bodies.items() if of in self.runs and of != about.run_id}
        self._bodies[body] = about.run_id
        while len(self.runs) > MAX_RUNS:
            self.has_forgotten = True
            del self.runs[min(self.runs, key=lambda one: self.runs[one].received_s)]
        return about

    @property
    def ids(self) -> list[str]:
        """The ids of the runs."""
        return [run_id for run_id in self.runs if run_id]

    @property
    def newest_s(self) -> float | None:
        """The arrival of the newest announcement of a run with an id, None before the first."""
        return max((self.runs[run_id].received_s for run_id in self.ids), default=None)

    @property
    def last_id(self) -> str | None:
        """The run with an id that announced itself last, None before the first."""
        return max(self.ids, key=lambda run_id: self.runs[run_id].received_s, default=None)

    def current_ids(self, now_s: float) -> list[str]:
        """Return the runs that still announce themselves, else the last ended one; in order of their start.

        ``now_s``: on the arrival clock.
        """
        current = [run_id for run_id in self.ids if now_s - self.runs[run_id].received_s < RUN_SILENT_S]
        return current or list(filter(None, [self.last_id]))

    def shown(self, chosen: str | None, now_s: float) -> str | None:
        """Return the run to show: the selected one while it is announced, else the newest; None without runs."""
        alive = [run_id for run_id, one in self.runs.items() if now_s - one.received_s < RUN_SILENT_S]
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
