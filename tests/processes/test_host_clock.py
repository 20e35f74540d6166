"""The clock of another host is found from answers with any delays; clocks that are set are told apart and counted."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from graphnav.core.graph import Part
from graphnav.processes import host_clock
from graphnav.processes.host_clock import ClockState, HostClock, OwnClock, Reading, read_clocks
from graphnav.processes.host_clock_notices import HostClockNotices

BOOT_NS = 1_000_000_000_000
WALL_NS = 1_795_000_000_000_000_000
SECOND_NS = 1_000_000_000
MS_NS = 1_000_000
Delays = Callable[[random.Random], tuple[float, float]]
"""Of a question and its answer, ms."""


def constant(there_ms: float, back_ms: float) -> Delays:
    """Return delays that never change."""
    return lambda _: (there_ms, back_ms)


def jitter(chance: random.Random) -> tuple[float, float]:
    """Return delays of Wi-Fi: half a millisecond, mostly a few more, sometimes hundreds."""
    return tuple(
        0.5 + chance.expovariate(1 / 4) + (300 * chance.random() if chance.random() < 0.05 else 0) for _ in range(2)
    )  # type: ignore[return-value]


class Simulation:
    """Two hosts: the clock of the other one is ahead by ``offset_s``, drifts, and is set by `step`."""

    def __init__(self, delays: Delays, offset_s: float = 0.0, drift_ppm: float = 0.0, seed: int = 1) -> None:
        self.clock = HostClock()
        self.own = OwnClock()
        self._delays, self._chance, self._drift = delays, random.Random(seed), drift_ppm * 1e-6
        self._offset_ns, self._own_ns = round(offset_s * SECOND_NS), 0
        self._t_ns = 0

    def step(self, step_s: float) -> None:
        """Set the other clock."""
        self._offset_ns += round(step_s * SECOND_NS)

    def step_own(self, step_s: float) -> None:
        """Set this machine's clock."""
        self._own_ns += round(step_s * SECOND_NS)

    def now(self) -> Reading:
        """Return this machine's clocks."""
        return Reading(BOOT_NS + self._t_ns, WALL_NS + self._t_ns + self._own_ns)

    def true_offset_s(self) -> float:
        """Return how far the other clock is ahead."""
        return (self._offset_ns + round(self._drift * self._t_ns) - self._own_ns) * 1e-9

    def run(self, duration_s: int, *, is_provable: bool = True) -> None:
        """Ask once a second; the estimate is never wrong by more than it says, unless a step cannot be proven."""
        for _ in range(duration_s):
            there_ms, back_ms = self._delays(self._chance)
            answered_ns = self._t_ns + round(there_ms * MS_NS) + 2 * MS_NS  # held for 2 ms
            wall_ns = WALL_NS + answered_ns + self._offset_ns + round(self._drift * answered_ns)
            heard_ns = answered_ns + round(back_ms * MS_NS)
            self.clock.add(BOOT_NS + self._t_ns, BOOT_NS + heard_ns, 2 * MS_NS, wall_ns)
            self._t_ns += max(SECOND_NS, heard_ns - self._t_ns)
            self.own.look(self.now())
            state = self.state()
            assert not is_provable or abs(state.offset_s - self.true_offset_s()) <= state.error_s + 1e-9

    def state(self) -> ClockState:
        """Return what is known of the other clock."""
        state = self.clock.state(self.now())
        assert state is not None
        return state


def test_nothing_is_known_before_an_answer() -> None:
    assert HostClock().state(read_clocks()) is None


@pytest.mark.parametrize("delays", [constant(0.2, 0.2), constant(0.1, 9.9), constant(40.0, 0.1), jitter])
@pytest.mark.parametrize("offset_s", [0.0, 0.0123, -3600.0, -1.7e9])
def test_an_offset_is_within_its_error_whatever_the_delays(delays: Delays, offset_s: float) -> None:
    made = Simulation(delays, offset_s)
    made.run(30)
    state = made.state()
    assert state.round_trip_s <= 0.0402
    assert state.error_s <= state.round_trip_s / 2 + 3.1e-3
    assert state.n_steps == 0
    assert state.drift_ppm is None, "half a minute is not enough"


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("drift_ppm", [50.0, -50.0])
@pytest.mark.parametrize("delays", [constant(0.2, 0.2), constant(0.1, 9.9), jitter])
def test_a_drift_is_found_and_is_not_a_step(delays: Delays, drift_ppm: float, seed: int) -> None:
    made = Simulation(delays, 0.5, drift_ppm, seed)
    made.run(400)
    assert made.state().drift_ppm == pytest.approx(drift_ppm, rel=0.1)
    assert made.state().n_steps == 0


def test_no_drift_is_told_where_the_answers_do_not_agree_on_one() -> None:
    made = Simulation(lambda chance: (500 * chance.random(), 500 * chance.random()), drift_ppm=50.0)
    made.run(400)
    assert made.state().drift_ppm is None


@pytest.mark.parametrize("delays", [constant(0.2, 0.2), constant(0.1, 9.9), jitter])
@pytest.mark.parametrize("step_s", [0.3, -0.3, 3600.0, -3600.0])
def test_a_step_is_noticed_once(delays: Delays, step_s: float) -> None:
    made = Simulation(delays, 12.0, 50.0)
    made.run(100)
    assert made.state().drift_ppm == pytest.approx(50.0, rel=0.2)
    for k in range(1, 6):
        made.step(step_s)
        made.run(20)
        state = made.state()
        assert state.n_steps == k
        assert state.step_s == pytest.approx(step_s, abs=0.01 if delays is not jitter else 0.31)
        assert state.drift_ppm is None, "all begins again"


def test_what_bad_answers_cannot_prove_is_noticed_by_the_first_good_one() -> None:
    delays_ms = [0.2, 0.2]
    made = Simulation(lambda _: (delays_ms[0], delays_ms[1]))
    made.run(5)
    delays_ms[:] = 100.0, 900.0  # as if it were 0.4 s behind, give or take 0.5 s
    made.step(0.3)
    made.run(5, is_provable=False)
    assert made.clock.n_steps == 0
    delays_ms[:] = 0.2, 0.2
    made.run(20)
    assert made.state().n_steps == 1
    assert made.state().step_s == pytest.approx(0.3, abs=1e-3)


@pytest.mark.parametrize("step_s", [0.3, -0.3, 3600.0, -3600.0])
def test_a_step_of_this_clock_is_not_one_of_the_other(step_s: float) -> None:
    made = Simulation(constant(0.2, 0.2), 1.0, 50.0)
    made.run(100)
    drift_ppm = made.state().drift_ppm
    made.own.look(made.now())
    made.step_own(step_s)
    assert made.own.look(made.now()) == pytest.approx(step_s)
    assert made.own.look(made.now()) == 0.0
    state = made.state()
    assert state.offset_s == pytest.approx(1.005 - step_s, abs=1e-3)
    assert (state.n_steps, state.drift_ppm) == (0, drift_ppm)
    made.run(100)
    assert made.state().n_steps == 0


def test_this_clock_is_not_set_where_it_is_read_slowly() -> None:
    own = OwnClock()
    assert own.look(Reading(0, WALL_NS)) == 0.0
    assert own.look(Reading(SECOND_NS, WALL_NS + SECOND_NS + 30 * MS_NS, 40 * MS_NS)) == 0.0
    assert own.look(Reading(2 * SECOND_NS, WALL_NS + 2 * SECOND_NS)) == 0.0
    assert own.look(Reading(3 * SECOND_NS, WALL_NS + 3 * SECOND_NS + 4 * MS_NS)) == 0.0
    assert own.look(Reading(4 * SECOND_NS, WALL_NS + 4 * SECOND_NS - 2 * MS_NS)) == pytest.approx(-0.006)


def test_clocks_are_read_again_where_the_process_is_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(host_clock, "boot_ns", iter([0, 9 * MS_NS, 10 * MS_NS, 10 * MS_NS + 1000]).__next__)
    assert read_clocks(iter([1, 2]).__next__) == Reading(10 * MS_NS + 500, 2, 500.0)


def test_an_answer_that_came_before_it_was_made_does_not_count() -> None:
    clock = HostClock()
    clock.add(BOOT_NS, BOOT_NS + MS_NS, MS_NS + 1, WALL_NS)
    assert clock.n_answers == 0
    assert clock.state(Reading(BOOT_NS + MS_NS, WALL_NS)) is None


def told(*clocks: tuple[str, int, float]) -> tuple[list[str], HostClockNotices]:
    """Return the notices of a run with two processes on a host that tell steps: process, how many, the last one."""
    lines: list[str] = []
    notices = HostClockNotices(lines.append)
    for name, n_steps, step_s in clocks:
        part = Part(name, (), host="jetson")
        notices.look(part, ClockState(0.001, 0.5, 0.001, None, n_steps, step_s))
    return lines, notices


def test_a_step_is_told_once_however_many_processes_live_there() -> None:
    first = "the clock of the host jetson was set 0.30 s ahead; the run goes by its own"
    second = "the clock of the host jetson was set 3600 s back; the run goes by its own"
    rounds = [("eyes", 0, 0.0), ("mind", 0, 0.0), ("eyes", 1, 0.3), ("mind", 1, 0.3), ("mind", 2, -3600.0)]
    lines, notices = told(*rounds, ("eyes", 2, -3600.0))
    assert lines == [first, second]
    assert notices.report(Part("mind", (), host="jetson")) == {"host": "jetson", "clock_steps": 2}
    assert notices.report(Part("hand", ())) == {}


def test_a_process_that_is_started_again_counts_on() -> None:
    lines, notices = told(("eyes", 0, 0.0), ("eyes", 1, 0.3), ("eyes", 0, 0.0), ("eyes", 1, -0.02))
    assert [line.split(";")[0].rpartition("was ")[2] for line in lines] == ["set 0.30 s ahead", "set 20.0 ms back"]
    part = Part("eyes", (), host="jetson")
    assert notices.fields(part, None) == {"host": "jetson", "clock_steps": 2}
    assert notices.fields(part, ClockState(0.001, -0.5, 0.002, 3.0, 1, 0.3)) == {
        "host": "jetson",
        "clock_steps": 2,
        "round_trip_ms": 1.0,
        "clock_offset_s": -0.5,
        "clock_error_s": 0.002,
        "clock_drift_ppm": 3.0,
    }
    assert notices.fields(Part("hand", ()), None) == {}
