"""Track the health of runs: the newest status of each run, and how long it has been silent."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from graphnav import About, GuardState, Status
from graphnav.core.codec import DecodeError, codec_of, decode
from graphnav.core.record import silent_after_s
from graphnav.watch.channel_account import Clock
from graphnav.watch.feed.announcements import MAX_RUNS, RUN_SILENT_S
from graphnav.watch.feed.feed import Received

_GUARD_SILENT_S = silent_after_s(None)
"""A guard, which sends its state many times a second, is silent after this time without one."""


@dataclass
class RunHealth:
    """One run: its newest status, None before the first, with that message's stamp (microseconds) and number.

    ``received_s``: the arrival of the status, or of the first message of the run, on the arrival clock.
    """

    run_id: str
    received_s: float
    status: Status | None = None
    utime: int = 0
    seq: int = 0


@dataclass(frozen=True)
class GuardHealth:
    """The newest state of a guard, its stamp (microseconds) and when it arrived."""

    channel: str
    received_s: float
    state: GuardState
    utime: int


class Health:
    """Runs by id and guards by channel, the newest 32 of each; other messages are ignored.

    ``clock`` returns the current time, seconds, on the arrival clock; without a clock, as for a log, none is silent.
    """

    def __init__(self, clock: Clock | None = None) -> None:
        self.runs: dict[str, RunHealth] = {}
        self.guards: dict[str, GuardHealth] = {}
        self.has_forgotten = False
        self._clock = clock

    @property
    def is_complete(self) -> bool:
        """Whether there is a run, and every known run has sent a status."""
        return bool(self.runs) and all(run.status is not None for run in self.runs.values())

    @property
    def has_status(self) -> bool:
        """Whether any run has sent a status."""
        return any(run.status is not None for run in self.runs.values())

    def receive(self, received: Received) -> bool:
        """Process a message; return whether it was a status. Undecodable messages are ignored."""
        try:
            mark = received.data[:8]
            if mark == codec_of(Status.lcm_class).fingerprint:
                utime, seq, status = decode(Status, received.data)
                self._keep_run(RunHealth(status.run_id, received.at_s, status, utime, seq))
                return True
            if mark == codec_of(GuardState.lcm_class).fingerprint:
                utime, _, state = decode(GuardState, received.data)
                self.guards.pop(received.channel, None)
                self.guards[received.channel] = GuardHealth(received.channel, received.at_s, state, utime)
                self._bound(self.guards)
            elif received.channel == About.CHANNEL and (run_id := decode(About, received.data)[2].run_id):
                self._keep_run(self.runs.get(run_id) or RunHealth(run_id, received.at_s))
        except DecodeError:
            pass
        return False

    def _keep_run(self, run: RunHealth) -> None:
        """Store a run as the newest one."""
        self.runs.pop(run.run_id, None)
        self.runs[run.run_id] = run
        self._bound(self.runs)

    def silent_s(self, of: RunHealth | GuardHealth) -> float | None:
        """Return the time since the last message of a run or guard; None for a log."""
        return None if self._clock is None else max(0.0, self._clock() - of.received_s)

    def is_silent(self, of: RunHealth | GuardHealth) -> bool:
        """Whether a run or guard has stopped sending its regular messages."""
        limit_s = RUN_SILENT_S if isinstance(of, RunHealth) else _GUARD_SILENT_S
        return (self.silent_s(of) or 0.0) > limit_s

    def motor_fault(self, guard: GuardHealth) -> str:
        """Return why the motor output of a guard's stage gets nothing, empty if it does or no status tells."""
        stage = guard.channel.rpartition(".")[0]
        for run in self.runs.values():
            for output in () if run.status is None or self.is_silent(run) else run.status.outputs:
                if output["motor"] and output["fault"] and output["name"].rpartition(".")[0] == stage:
                    return str(output["fault"])
        return ""

    def _bound(self, newest_last: dict[str, Any]) -> None:
        """Drop the oldest entries."""
        while len(newest_last) > MAX_RUNS:
            self.has_forgotten = True
            del newest_last[next(iter(newest_last))]
