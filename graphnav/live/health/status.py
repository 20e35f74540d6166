"""Build the status of a live run, published on `graphnav.status` once a second."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from graphnav import Status
from graphnav.core.runner import ProcessStatuses, Rates, edge_statuses, memory_mb
from graphnav.live.health.clocks import Clocks
from graphnav.live.health.motor_traffic import MotorTraffic
from graphnav.live.inputs.intake import Intake
from graphnav.live.live_schedule import LiveSchedule
from graphnav.live.outlet import Outlet

_PERIOD_S = 1.0
_RECENT_S = 3.0
"""The age up to which the detail of a rejection is shown."""


class Losses(NamedTuple):
    """Messages dropped by the tap and the log, and why the log takes none at present."""

    tap_dropped: int
    log_dropped: int
    log_fault: str


class StatusReporter:
    """Builds a status once a second; ``losses`` returns what the tap and the log lose."""

    def __init__(
        self,
        schedule: LiveSchedule,
        run_id: str,
        losses: Callable[[], Losses],
        traffic: MotorTraffic,
        clocks: Clocks,
    ) -> None:
        self._schedule, self._run_id, self._losses, self._traffic, self._clocks = (
            schedule,
            run_id,
            losses,
            traffic,
            clocks,
        )
        self._due_s = schedule.clock.now_s() + _PERIOD_S
        self._last_s = schedule.clock.now_s()
        self._rates = Rates()
        self._processes = ProcessStatuses()

    def is_due(self) -> bool:
        """Whether the last status is a second old."""
        return self._schedule.clock.now_s() >= self._due_s

    def make(self) -> Status:
        """Return the current status; rates are averages since the last one."""
        clock = self._schedule.clock
        now_s = clock.now_s()
        elapsed_s = max(now_s - self._last_s, 1e-6)
        self._last_s, self._due_s = now_s, now_s + _PERIOD_S
        units, states = self._schedule.engine.units, self._schedule.process_states
        overtaken = self._schedule.overtaken()
        losses = self._losses()
        return Status(
            run_id=self._run_id,
            graph=self._schedule.graph.path.stem,
            live=True,
            wall_s=clock.run_s(),
            run_s=clock.run_s(),
            behind_s=self._schedule.behind_s(now_s),
            memory_mb=memory_mb(),
            tap_dropped=losses.tap_dropped,
            log_dropped=losses.log_dropped,
            log_fault=losses.log_fault,
            stages=self._rates.stage_statuses(units, elapsed_s),
            inputs=tuple(self._input(one, now_s, elapsed_s) for one in self._schedule.intakes.values()),
            outputs=tuple(_output(one, self._traffic) for one in self._schedule.outlets.values()),
            edges=edge_statuses((unit.node for unit in units.values()), overtaken, has_processes=bool(states)),
            processes=self._processes.make(states, units),
        )

    def _input(self, intake: Intake, now_s: float, elapsed_s: float) -> dict[str, Any]:
        source, monitor = intake.source, intake.monitor
        reasons = sorted(monitor.rejected.items())
        return {
            "name": source.channel.ref,
            "channel": f"{source.log}:{source.name}" if source.log is not None else source.name,
            "accepted": intake.used + intake.overtaken,
            "rate_hz": self._rates.since(f"{source.channel.ref} used", intake.used + intake.overtaken) / elapsed_s,
            "lost": intake.lost,
            "age_s": intake.age_s(now_s) if intake.used else -1.0,
            "max_age_s": monitor.max_age_s,
            "offset_s": monitor.offset_s,
            "fault": monitor.fault(now_s),
            "clock": self._clocks.notes.get(source.channel.ref, ""),
            "reasons": tuple(reason for reason, _ in reasons),
            "rejected": tuple(count for _, count in reasons),
            "details": tuple(monitor.detail(reason, now_s - _RECENT_S) for reason, _ in reasons),
        }


def _output(outlet: Outlet, traffic: MotorTraffic) -> dict[str, Any]:
    return {
        "name": outlet.target.channel.ref,
        "channel": outlet.target.name,
        "motor": outlet.target.motor,
        "sent": outlet.sent,
        "refused": outlet.refused,
        "fault": traffic.fault if outlet.target.motor else "",
        "latency_p50_ms": outlet.latency.quantile_s(0.5) * 1e3,
        "latency_p99_ms": outlet.latency.quantile_s(0.99) * 1e3,
        "latency_max_ms": outlet.max_latency_s * 1e3,
    }
