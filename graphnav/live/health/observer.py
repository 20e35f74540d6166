"""Watching a live run from inside: its status once a second, and what a person should know."""

from __future__ import annotations

from collections.abc import Callable

from graphnav.codec import encode
from graphnav.live.health.alarms import Alarms
from graphnav.live.health.motor_traffic import MotorTraffic
from graphnav.live.health.status import StatusReporter
from graphnav.live.live_runner import LiveRunner
from graphnav.runner.lockstep_status import STATUS

_MAX_TOLD = 100
"""Notices that are kept for the summary."""


class Observer:
    """Publishes ``graphnav.status`` once a second and tells, through ``notice``, what is late, lost or hangs.

    ``dropped`` returns what the tap and the log have dropped. ``told``: the first 100 notices. ``traffic`` is to count
    what comes by on the motor channels. ``status`` is the newest one that was made.
    """

    def __init__(
        self, runner: LiveRunner, run_id: str, dropped: Callable[[], tuple[int, int]], notice: Callable[[str], None]
    ) -> None:
        self.told: list[str] = []
        self.traffic = MotorTraffic()
        self._runner, self._notice = runner, notice
        self._alarms = Alarms(runner, self.traffic.counts)
        self._reporter = StatusReporter(runner, run_id, dropped)
        self.status = self._reporter.make()

    def tell(self, line: str) -> None:
        """Tell a person something; from any thread."""
        if len(self.told) < _MAX_TOLD:
            self.told.append(line)
        self._notice(line)

    def look(self) -> bool:
        """Publish a status and tell what is new, if the last one is a second old; return whether it was."""
        if not self._reporter.is_due():
            return False
        runner = self._runner
        self.status = self._reporter.make()
        runner.record(STATUS, encode(self.status, runner.clock.now(), runner.next_seq(STATUS)))
        for line in self._alarms.look():
            self.tell(line)
        return True

    def finish(self) -> None:
        """Look a last time, at the end of the run."""
        self.status = self._reporter.make()

    def tell_broken_off(self) -> None:
        """Tell within which step the run was broken off, if within one."""
        if self._runner.step_began is not None:
            name, began_s = self._runner.step_began
            self.tell(f"broken off within a step of {name} that had taken {self._runner.clock.now_s() - began_s:.1f} s")
