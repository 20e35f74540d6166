"""The clocks of the hosts of a run: notices when one is set, this machine's too, and what its status says of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from graphnav.core.graph import Part
from graphnav.core.machine import set_text
from graphnav.processes.host_clock import ClockState, OwnClock, read_clocks


class HostClockNotices:
    """Tells each step once, however many processes of the run live on the host, each of which measures its clock."""

    def __init__(self, notice: Callable[[str], None]) -> None:
        self._notice = notice
        self._own = OwnClock()
        self._seen: dict[str, int] = {}
        self._steps: Counter[str] = Counter()
        """By process, over all connections of it."""
        self._told: Counter[str] = Counter()
        """By host."""
        self._newest: dict[str, ClockState | None] = {}

    def look(self, part: Part, clock: ClockState | None) -> None:
        """Learn what a process knows of the clock of its host, if that is new."""
        if part.host is None or clock is None or clock is self._newest.get(part.name):
            return
        self._newest[part.name] = clock
        if own_s := self._own.look(read_clocks()):
            self._notice(f"the clock of this machine {set_text(own_s)}; that of the run goes on as before")
        seen = self._seen.get(part.name, 0)
        self._seen[part.name] = clock.n_steps
        self._steps[part.name] += max(0, clock.n_steps - seen)
        if self._steps[part.name] > self._told[part.host]:
            self._told[part.host] = self._steps[part.name]
            self._notice(f"the clock of the host {part.host} {set_text(clock.step_s)}; the run goes by its own")

    def fields(self, part: Part, clock: ClockState | None) -> dict[str, Any]:
        """Return what a `ProcessState` says of the host of a process."""
        if part.host is None:
            return {}
        found: dict[str, Any] = {"host": part.host, "clock_steps": self._told[part.host]}
        if clock is not None:
            found["round_trip_ms"] = 1e3 * clock.round_trip_s
            found["clock_offset_s"], found["clock_error_s"] = clock.offset_s, clock.error_s
            if clock.drift_ppm is not None:
                found["clock_drift_ppm"] = clock.drift_ppm
        return found

    def report(self, part: Part) -> Mapping[str, Any]:
        """Return the entries of a process in the summary."""
        return {} if part.host is None else {"host": part.host, "clock_steps": self._told[part.host]}
