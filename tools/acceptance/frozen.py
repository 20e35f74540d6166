"""Frozen pictures, wrong odometry, spinning wheels: live drives that must stop without a contact, or must not stop."""

from __future__ import annotations

import math
import random
import tempfile
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import Any, NamedTuple

from acceptance.drives import drive, say
from acceptance.guarding import guard_item
from acceptance.processes import drives_forward, hear
from acceptance.rig import Rig
from graphnav import GuardState, Recording, State
from graphnav.core.record import LOG

FIRST_NUMBER = 171
MAX_DRIVE_S = 90.0
FALSE_LIVE_S = 90.0
"""Of each live drive that must not stop: 30 minutes with 20 seeds."""
WATCHED_S = 12.0
TURNS_S = 40.0
"""The same for a heading of the wrong sign, which shows only in turns: the straight parts of a drive last 10 s."""
STOP_S, HANGING_STOP_S = 0.75, 2.6
"""Time until the guard forbids motion: 0.4 s of evidence, a period of camera and guard, and a busy machine; where
odometry hangs as the picture does 2 s of evidence.
"""
SETTLE_S = 0.5
"""Of a robot that drives off with a frozen picture, more: what a command does is asked for this long after it."""
SPEED_MPS, MORE_M = 0.3, 0.04 + 0.1
"""The speed until then; braking and the retry; a robot that drives off again may go as far once more."""
SEEING_FAULTS: dict[str, Mapping[str, Mapping[str, Any]]] = {
    "frozen": {"CAMERA": {"freeze_gray": 0.0}},
    "frozen, noise": {"CAMERA": {"freeze_gray": 1.0}},
    "covered, dark": {"CAMERA": {"picture": "covered"}},
    "covered, texture": {"CAMERA": {"picture": "cloth"}},
    "spinning wheels": {"BASE_CMD": {"stand": True}, "ODOMETRY": {"spin": True}},
}
"""Faults by the channels that have them; all with new stamps, those of covered lenses with noise of 1 gray level."""
HANGING: Mapping[str, Mapping[str, Any]] = {"CAMERA": {"freeze_gray": 0.0}, "ODOMETRY": {"hold": True}}
SEEING_CAUSES = frozenset({"frozen", "blind"})
COVERED = "covered, dark", "covered, texture"
"""Covers may look like obstacles: then the robot stands for that, and only its way is limited."""
UNJUDGED = ("--set", "guard.frozen_px=0")
"""Of the baseline: the same faults are then not named."""
ODOMETRY_FAULTS = ("jump", "zero", "reversed", "degrees")
ODOMETRY_CAUSES = frozenset({"jump", "turn_jump", "motionless", "reversed", "scale"})
"""Each names odometry; which comes first depends on the heading at the moment of the fault, which may jump, too."""
CONDITIONS = (
    ("corridor_ccw", ("robot.rate_hz=30",)),
    ("corridor_ccw", ("robot.rate_hz=30", "control.max_speed_mps=0.05")),
    ("corridor_ccw", ("robot.noise_sigma_gray=0",)),
    ("navigate", ("control.max_speed_mps=0.05",)),
    ("paper_corridor_ccw", ("robot.rate_hz=30",)),
)


class Trial(NamedTuple):
    """A live drive with faults, by channel; ``causes``: those that name it; ``options`` of the graph."""

    graph: str
    name: str
    faults: Mapping[str, Mapping[str, Any]]
    causes: frozenset[str]
    seed: int
    options: Sequence[str] = ()


class Result(NamedTuple):
    """Seconds from the fault until motion was forbidden for a cause that names it, which, and what the robot did.

    ``paused``: how many times it stood before for another cause, such as a late input on a busy machine; the seconds
    then count from the last time that it was allowed to drive off.
    """

    trial: Trial
    stop_s: float
    paused: int
    cause: str
    way_m: float
    contact: bool


def frozen_item(seeds: Sequence[int], jobs: int) -> bool:
    """Freeze or cover the picture, or let the wheels spin, in two graphs; spoil odometry in four ways."""
    half = seeds[: max(len(seeds) // 2, 1)]
    trials = [
        Trial(graph, name, faults, SEEING_CAUSES, seed)
        for graph in ("navigate_live", "navigate_robot")
        for name, faults in SEEING_FAULTS.items()
        for seed in half
    ]
    trials += [Trial("navigate_live", "frozen with odometry", HANGING, SEEING_CAUSES, seed) for seed in half]
    trials += [
        Trial("navigate_live", name, {"ODOMETRY": {"odometry": name}}, ODOMETRY_CAUSES, seed)
        for name in ODOMETRY_FAULTS
        for seed in half
    ]
    trials += [
        Trial(graph, f"{name}, baseline of frozen_px 0", SEEING_FAULTS[name], SEEING_CAUSES, seeds[0], UNJUDGED)
        for graph in ("navigate_live", "navigate_robot")
        for name in ("frozen", "covered, texture", "spinning wheels")
    ]
    numbers: SimpleQueue[int] = SimpleQueue()
    for number in range(FIRST_NUMBER, FIRST_NUMBER + jobs):
        numbers.put(number)
    with ThreadPoolExecutor(jobs) as pool:
        results = list(pool.map(lambda trial: _met(trial, numbers), trials))
    passed = True
    for graph, name in dict.fromkeys((trial.graph, trial.name) for trial in trials):
        passed &= _told(graph, name, [r for r in results if (r.trial.graph, r.trial.name) == (graph, name)])
    return passed


def _watched_s(trial: Trial) -> float:
    return TURNS_S if trial.name == "reversed" else WATCHED_S


def _told(graph: str, name: str, results: Sequence[Result]) -> bool:
    contacts = sum(one.contact for one in results)
    trial = results[0].trial
    is_seeing = trial.causes == SEEING_CAUSES
    max_seen_s = HANGING_STOP_S if trial.faults is HANGING else STOP_S
    max_stop_s = max_seen_s if is_seeing and trial.name not in COVERED else _watched_s(trial)
    max_way_m = SPEED_MPS * max_seen_s + MORE_M if is_seeing else math.inf
    passed = all(one.stop_s == math.inf for one in results) if trial.options else not contacts
    named = Counter(one.cause for one in results)
    words = [f"{dict(named)} of {len(results)}"]
    for what, some in (
        ("", [one for one in results if not one.paused]),
        (" of those that had stood before for another cause, from driving off", [one for one in results if one.paused]),
    ):
        if some:
            settle_s = SETTLE_S if what else 0.0
            starts = 1 + max(one.paused for one in some)
            times, ways = sorted(one.stop_s for one in some), [one.way_m for one in some]
            if not trial.options:
                passed &= times[-1] <= max_stop_s + settle_s and max(ways) <= starts * max_way_m
            words.append(
                f"{len(some)}{what}: after {times[len(times) // 2]:.2f} s, worst {times[-1]:.2f}; way after the fault "
                f"{max(ways):.2f} m at most"
            )
    say(f"{'ok  ' if passed else 'MISS'} {graph}, {name}: {'; '.join(words)}; contacts {contacts}")
    return passed


def _met(trial: Trial, numbers: SimpleQueue[int]) -> Result:
    number = numbers.get()
    rng = random.Random(f"{trial.name} {trial.seed}")
    try:
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch)
            with Rig(folder, number, trial.seed, ("--set", "robot.state_hz=100"), MAX_DRIVE_S) as rig:
                rig.navigate(trial.graph, trial.options)
                hear(rig.graph_url, "BASE_CMD", drives_forward)
                time.sleep(rng.uniform(1.0, 5.0))
                begin_s = time.time()
                for channel, fault in trial.faults.items():
                    rig.fault(fault, channel)
                end_s = begin_s + _watched_s(trial)
                while time.time() < end_s and rig.is_driving:
                    time.sleep(0.05)
                rig.robot.terminate()
                rig.finish()
            return Result(trial, *_measured(folder, trial, begin_s))
    finally:
        numbers.put(number)


def _measured(folder: Path, trial: Trial, begin_s: float) -> tuple[float, int, str, float, bool]:
    stop_s, cause, way_m, contact, before_s = math.inf, "not named", 0.0, False, begin_s
    free_s, stands, paused = begin_s, False, 0
    with Recording(folder / "navigation-0" / LOG) as log:
        for utime, _, state in log.messages("guard.state"):
            assert isinstance(state, GuardState)
            named = [one for one in state.causes if one in trial.causes]
            if utime * 1e-6 < begin_s:
                continue
            if not state.may_move and named:
                stop_s, cause = utime * 1e-6 - free_s, named[0]
                break
            if stands and state.may_move:
                free_s, paused = utime * 1e-6, paused + 1
            stands = not state.may_move
    with Recording(folder / "robot" / LOG) as log:
        for utime, _, state in log.messages("robot.state"):
            assert isinstance(state, State)
            if utime * 1e-6 >= begin_s:
                way_m += abs(state.v_mps) * (utime * 1e-6 - before_s)
                before_s, contact = utime * 1e-6, contact or state.contact
    return stop_s, paused, cause, way_m, contact


def frozen_false_item(seeds: Sequence[int], jobs: int) -> bool:
    """Drive every shipped graph that has a guard, some under other conditions, and two live; count false stops."""
    passed = guard_item(seeds, jobs)
    for graph, sets in CONDITIONS:
        with ThreadPoolExecutor(jobs) as pool:
            counts = list(pool.map(lambda seed, graph=graph, sets=sets: _false_in(graph, seed, sets), seeds))
        passed &= _counted(f"{graph} {' '.join(sets)}", counts)
    for place, graph in enumerate(("navigate_live", "navigate_robot")):
        numbers: SimpleQueue[int] = SimpleQueue()
        for number in range(FIRST_NUMBER, FIRST_NUMBER + jobs):
            numbers.put(number)
        with ThreadPoolExecutor(jobs) as pool:
            half = seeds[place::2]
            counts = list(pool.map(lambda seed, graph=graph, numbers=numbers: _false_live(graph, seed, numbers), half))
        passed &= _counted(f"{graph} live, {FALSE_LIVE_S * len(half) / 60:.1f} min", counts)
    return passed


def _counted(name: str, counts: Sequence[tuple[int, int]]) -> bool:
    false, firings = sum(one for one, _ in counts), sum(one for _, one in counts)
    mark = "MISS" if false or not firings else "ok  "
    say(f"{mark} {name}: {false} false of {firings} firings in {len(counts)} drives")
    return not false and firings > 0


def _false_in(graph: str, seed: int, sets: Sequence[str]) -> tuple[int, int]:
    with tempfile.TemporaryDirectory() as scratch:
        drive(graph, seed, ("run.record=small", *sets), Path(scratch) / "run")
        return _false(Path(scratch) / "run")


def _false_live(graph: str, seed: int, numbers: SimpleQueue[int]) -> tuple[int, int]:
    """Drive for a fixed time; where the drive arrives before, it goes on as the next corridor."""
    number = numbers.get()
    found = [0, 0]
    end_s = time.monotonic() + FALSE_LIVE_S
    try:
        while (left_s := end_s - time.monotonic()) > 5.0:
            with tempfile.TemporaryDirectory() as scratch:
                with Rig(Path(scratch), number, seed, (), left_s) as rig:
                    rig.navigate(graph)
                    rig.finish()
                for place, count in enumerate(_false(Path(scratch) / "navigation-0")):
                    found[place] += count
            seed += 100
        return found[0], found[1]
    finally:
        numbers.put(number)


def _false(run: Path) -> tuple[int, int]:
    """Return at how many firings the guard named an input that contradicts the motion, of how many."""
    with Recording(run / LOG) as log:
        states = [state for _, _, state in log.messages("guard.state") if isinstance(state, GuardState)]
    return sum(bool((ODOMETRY_CAUSES | {"frozen"}) & set(state.causes)) for state in states), len(states)
