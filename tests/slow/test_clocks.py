"""Stamps of wrong units and clocks on a live robot: the lines that are printed, and how often the guard switches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from testbed.relay import STAMPS
from testbed.rig import Rig

from graphnav import GuardState, Recording
from graphnav.core.run_folder import RunFolder
from tests.targets import Targets

NUMBER = 215
LOOK_S = 10.0
SETTLES_S = 1.0
MAX_SWITCHES = 2
JITTER_S = 0.03
OFFSETS_S = (0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7)
SYMPTOMS = ("late: ", "overtaken: ", "not used: ")


class Case(NamedTuple):
    """A fault of the camera's stamps and what a line has to say of it."""

    name: str
    fault: Mapping[str, Any]
    said: str


_UNIT = "clock: camera.image on CAMERA: stamps look like {0}: utime is in microseconds, "
CASES = (
    *(Case(f"stamps in {unit}", {"stamps": unit}, _UNIT.format(unit)) for unit in ("seconds", "milliseconds")),
    Case("stamps in nanoseconds", {"stamps": "nanoseconds"}, _UNIT.format("nanoseconds")),
    Case("stamps of CLOCK_MONOTONIC", {"stamps": "CLOCK_MONOTONIC"}, "stamps are of CLOCK_MONOTONIC"),
    Case("stamps of 0", {"stamps": "zero"}, "utime is 0: the sender sets no stamp"),
    *(Case(f"{s:.2f} s behind", {"jump_s": -s, "jitter_s": JITTER_S}, "its clock is 0.") for s in OFFSETS_S),
    Case("0.42 s ahead", {"jump_s": 0.42, "jitter_s": JITTER_S}, "ahead of this machine's"),
    Case("12.3 s ahead", {"jump_s": 12.3}, "stamps of CAMERA are 12.3"),
    Case("two hours ahead", {"jump_s": 7200.0}, "(2 h: local time in place of UTC?)"),
)
assert {case.fault["stamps"] for case in CASES if "stamps" in case.fault} == set(STAMPS)


def test_clocks(targets: Targets, seeds: range, tmp_path: Path) -> None:
    """Navigate with each fault of the camera's stamps, the first as many as there are seeds; print the lines."""
    cases = CASES[: len(seeds)]
    duration_s = (LOOK_S + 10.0) * len(cases) + 30.0
    with Rig(tmp_path, NUMBER, seeds[0], ("--set", "robot.ends=false"), duration_s) as rig:
        for number, case in enumerate(cases):
            rig.fault(case.fault)
            rig.navigate(options=("--until", str(LOOK_S + SETTLES_S))).wait(60)
            printed = (tmp_path / f"navigation-{number}.txt").read_text().splitlines()
            _judge(targets, case, printed, tmp_path / f"navigation-{number}")


def _judge(targets: Targets, case: Case, printed: Sequence[str], run: Path) -> None:
    """Print what a run said of a fault; check whether that was it."""
    with Recording(run / RunFolder.LOG) as log:
        states = [(utime, one) for utime, _, one in log.messages("guard.state") if isinstance(one, GuardState)]
    begin = states[0][0] + SETTLES_S * 1e6
    moves = [state.may_move for utime, state in states if utime >= begin]
    switches = sum(a != b for a, b in pairwise(moves))
    told = [line for line in printed if line.startswith("clock: ")]
    symptoms = [line for line in printed if line.startswith(SYMPTOMS)]
    is_told = any(case.said in line for line in told)
    targets.check(
        f"{case.name}: {switches} switches in {LOOK_S:g} s, may move {sum(moves) / len(moves):.0%} of it",
        good=is_told and not symptoms and switches <= MAX_SWITCHES,
    )
    for line in (*told, *symptoms):
        targets.say(f"  {line}")
