"""How fast a robot was told to stop, how fast it stood, by its own log."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import NamedTuple

from testbed.rig import summary_of

from graphnav import Recording, State
from graphnav.core.run_folder import RunFolder

MAX_AGE_S = 0.5
GUARD_PERIOD_S = 0.05
WORLD_PERIOD_S = 0.01
SPEED_UP_MPS2 = 0.5 / 0.25
TURN_UP_RADPS2 = 2.0 / 0.25
"""The world's drive: maximum speeds divided by the time to reach them."""

_STANDING = 1e-6
_NONE = float("inf")


class Measured(NamedTuple):
    """Measurements of one fault.

    ``stop_s``: from its begin to the first stop. ``stand_s``: from there until the robot stood; ``allowed_s``: the
    time that a world period and braking from its speed take.
    """

    name: str
    stops: bool
    stop_s: float | None
    stand_s: float | None
    allowed_s: float | None
    contact: bool
    drove_on: bool
    n_stops: int


class States:
    """The states in a robot's log by monotonic time; ``clock_s``: the wall clock less the monotonic one."""

    def __init__(self, run: Path, clock_s: float) -> None:
        self.outcome: str = summary_of(run)["outcome"]
        self._times: list[float] = []
        self._states: list[State] = []
        with Recording(run / RunFolder.LOG) as log:
            for utime, _, state in log.messages("robot.state"):
                assert isinstance(state, State)
                self._times.append(utime / 1e6 - clock_s)
                self._states.append(state)

    def speed_at(self, time_s: float) -> float:
        """Return the speed at a time, NaN before the first state."""
        place = bisect_right(self._times, time_s) - 1
        return self._states[place].v_mps if place >= 0 else float("nan")

    def stand(self, stop_s: float) -> tuple[float | None, float | None]:
        """Return how long after a stop arrived the robot stood, None if it never did, and how long it may take.

        That is a world period and braking from the maximum speed after the arrival: within the period the robot may
        still speed up. The log has a state every world period; within the last one the robot brakes as before.
        """
        place = max(bisect_right(self._times, stop_s) - 1, 0)
        allowed_s = 0.0
        while not _stands(self._states[place]):
            allowed_s = max(allowed_s, WORLD_PERIOD_S + _braking_s(self._states[place]))
            place += 1
            if place == len(self._states):
                return None, allowed_s
        stood_s = self._times[place]
        if place:
            stood_s = min(stood_s, self._times[place - 1] + _braking_s(self._states[place - 1]))
        return max(stood_s - stop_s, 0.0), allowed_s

    def contact_between(self, begin_s: float, end_s: float) -> bool:
        """Return whether the robot touched anything."""
        pairs = zip(self._times, self._states, strict=True)
        return any(state.contact for time_s, state in pairs if begin_s <= time_s <= end_s)


def lines(name: str, measured: Sequence[Measured], n_wanted: int) -> tuple[bool, str]:
    """Return whether a kind of fault was met as it has to be, and what to print of it."""
    contacts = sum(one.contact for one in measured)
    drove_on = sum(one.drove_on for one in measured)
    passed = len(measured) >= n_wanted and not contacts and drove_on == len(measured)
    words = [f"n {len(measured)}"]
    if measured and not measured[0].stops:
        words.append(f"needs no stop: {sum(one.n_stops > 0 for one in measured)} of them stopped at all")
    else:
        stops = [_NONE if one.stop_s is None else one.stop_s for one in measured]
        stands = [_NONE if one.stand_s is None else one.stand_s for one in measured]
        over = [
            _NONE if one.stand_s is None or one.allowed_s is None else one.stand_s - one.allowed_s for one in measured
        ]
        limit_s = MAX_AGE_S + GUARD_PERIOD_S
        passed &= max(stops, default=_NONE) <= limit_s and max(over, default=_NONE) <= 0.0
        if measured:
            words.append(f"stop after {median(stops):.3f} s, worst {max(stops):.3f} (limit {limit_s:.2f})")
            words.append(f"stands {median(stands):.3f} s later, worst {max(stands):.3f}, {max(over):+.3f} of its limit")
    words += [f"contacts {contacts}", f"drives on {drove_on} of {len(measured)}"]
    return passed, f"{name}: {'; '.join(words)}"


def _stands(state: State) -> bool:
    return abs(state.v_mps) < _STANDING and abs(state.omega_radps) < _STANDING


def _braking_s(state: State) -> float:
    return max(abs(state.v_mps) / SPEED_UP_MPS2, abs(state.omega_radps) / TURN_UP_RADPS2)
