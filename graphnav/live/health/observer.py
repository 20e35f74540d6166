"""Observe a live run from inside: its status once a second, and notices."""

from __future__ import annotations

from collections.abc import Callable

from graphnav import Status
from graphnav.core.codec import encode
from graphnav.core.dds import Ros2Node
from graphnav.live.health.alarms import Alarms
from graphnav.live.health.clocks import Clocks
from graphnav.live.health.guard_holds import GuardHolds
from graphnav.live.health.motor_traffic import MotorTraffic
from graphnav.live.health.status import Losses, StatusReporter
from graphnav.live.inputs.receiver import Receiver
from graphnav.live.live_schedule import LiveSchedule

_MAX_TOLD = 100
"""Maximum number of notices in the summary."""


class Observer:
    """Publishes ``graphnav.status`` once a second and reports through ``notice`` what is late, lost or hangs.

    ``losses`` returns what the tap and the log lose. ``told``: the first 100 notices. ``traffic`` counts
    the messages on the motor channels. ``receiver`` and ``topics`` are set when they listen. ``status``: the newest
    status. ``url``: of the run's inputs and outputs.
    """

    def __init__(
        self, schedule: LiveSchedule, run_id: str, url: str, losses: Callable[[], Losses], notice: Callable[[str], None]
    ) -> None:
        self.told: list[str] = []
        self.traffic = MotorTraffic()
        self._schedule, self._notice = schedule, notice
        self.receiver: Receiver | None = None
        self.topics: Ros2Node | None = None
        self._holds = GuardHolds(schedule, url)
        clocks = Clocks(schedule)
        self._alarms = Alarms(schedule, self.traffic, clocks)
        self._reporter = StatusReporter(schedule, run_id, losses, self.traffic, clocks)
        self.status = self._reporter.make()

    def tell(self, line: str) -> None:
        """Report a notice; may be called from any thread."""
        if len(self.told) < _MAX_TOLD:
            self.told.append(line)
        self._notice(line)

    def look(self) -> bool:
        """If the last status is a second old, publish a new one and report new alarms; return whether it did.

        A motor process that takes no commands, or takes them again, is reported at once, and so is what holds the
        robot.
        """
        schedule = self._schedule
        for line in self._holds.look(schedule.clock.now_s()):
            self.tell(line)
        changes = list(self.traffic.look(schedule.clock.now_s()))
        schedule.withhold_commands(is_withheld=self.traffic.is_substituted)
        for line in changes:
            self.tell(line)
        if not (changes or self._reporter.is_due()):
            return False
        lines = list(self._alarms.look(self.receiver, self.topics))
        self.status = self._reporter.make()
        self._publish()
        for line in lines:
            self.tell(line)
        return True

    def in_one_line(self) -> str:
        """Return the newest status in short: since when it runs, and what is faulty."""
        status = self.status
        told = [(one["name"], one["fault"] or ("" if one["accepted"] else "no message yet")) for one in status.inputs]
        told += [(one["name"], one["fault"]) for one in status.outputs]
        faults = [f"{name}: {fault}" for name, fault in (*told, ("log", status.log_fault)) if fault]
        return f"runs for {status.run_s:.0f} s; {'; '.join(faults) or 'no fault'}"

    def finish(self) -> None:
        """Tell what is left to tell of devices, and make the last status, at the end of the run."""
        for line in self._alarms.of_sources():
            self.tell(line)
        self._alarms.close()
        self.status = self._reporter.make()

    def tell_processes(self) -> None:
        """Publish the last status where it says which process is gone."""
        if self.status.processes:
            self._publish()

    def _publish(self) -> None:
        schedule, now = self._schedule, self._schedule.clock.now()
        schedule.sink.write(Status.CHANNEL, now, encode(self.status, now, schedule.engine.number(Status.CHANNEL)))

    @property
    def dropped_packets(self) -> int:
        """Number of packets for the inputs that the kernel dropped."""
        return self.receiver.packet_loss().packets if self.receiver is not None else 0

    def tell_broken_off(self) -> None:
        """Report the steps in which the run was interrupted."""
        for name, began_s in self._schedule.steps.items():
            self.tell(f"interrupted a step of {name} after {self._schedule.clock.now_s() - began_s:.1f} s")
