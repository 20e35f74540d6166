"""A live run says on its terminal what holds the robot: once, with what an operator has to do, and its end."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from graphnav import GuardState, Image
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph
from graphnav.live.health.guard_holds import Hold

if TYPE_CHECKING:
    from tests.live.conftest import Live, Outside

    Begin = Callable[..., Live]
    Program = Callable[..., Outside]

URL = "udpm://239.255.76.67:7667?ttl=0"
FREE = GuardState(
    may_move=True,
    may_advance=True,
    overridden=False,
    stopped=False,
    causes=(),
    ports=(),
    values=np.empty(0),
    limits=np.empty(0),
)


@pytest.fixture(autouse=True)
def default_group(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("LCM_DEFAULT_URL", raising=False)


Cause = tuple[str, str, float, float]
STALE: Cause = ("stale", "image", 0.75, 0.5)
PLANE: Cause = ("stale", "plane", 0.85, 0.5)
FROZEN: Cause = ("frozen", "flow", 0.02, 0.1)
STOP: Cause = ("stop", "stop", 0.0, 0.0)
REVERSED: Cause = ("reversed", "odometry", -1.0, 0.0)
OBSTACLE: Cause = ("obstacle", "plane", 0.95, 0.9)
ARM = "\n  look, then press r to arm it or drive it by hand in: graphnav teleop"


def held(*causes: Cause, **fields: Any) -> GuardState:
    names, ports, values, limits = zip(*causes, strict=True)
    state = replace(FREE, causes=names, ports=ports, values=np.array(values), limits=np.array(limits))
    return replace(state, **({"may_move": False, "may_advance": False} | fields))


class Told:
    """The lines of one guard whose state is seen every 50 ms."""

    def __init__(self, sets: str = "", url: str = URL) -> None:
        graph = load_graph("navigate_live", Catalog()) if not sets else load_graph(sets, Catalog())
        self._hold = Hold(graph, "guard", url)
        self._now_s = 100.0

    def over(self, seconds: float, state: GuardState) -> list[str]:
        lines: list[str] = []
        for _ in range(round(seconds / 0.05)):
            lines += self._hold.see(state, self._now_s)
            self._now_s += 0.05
        return lines


def test_a_stop_that_lasts_is_told_once_with_its_causes_and_its_end() -> None:
    told = Told()
    stale = held(PLANE, STALE)
    assert told.over(1.9, stale) == []
    stands = "guard: the robot stands: stale: image, 0.75 s (limit 0.5 s); stale: plane, 0.85 s (limit 0.5 s)"
    assert told.over(60.0, stale) == [stands]
    assert told.over(1.0, FREE) == []
    assert told.over(5.0, stale) == [], "it flickers"
    assert told.over(30.0, FREE) == ["guard: the robot may move again, after 67.9 s: stale"]


def test_a_flicker_is_not_told() -> None:
    told = Told()
    for _ in range(50):
        assert told.over(0.5, held(STALE)) + told.over(0.5, FREE) == []
    assert told.over(10.0, FREE) == []


def test_a_robot_that_turns_away_from_obstacles_is_not_told_and_one_that_stays_is() -> None:
    told, turns = Told(), held(OBSTACLE, may_move=True)
    assert told.over(9.0, turns) + told.over(3.0, FREE) == []
    assert told.over(60.0, turns) == [
        "guard: the robot may turn, but not go forward: obstacle: plane, 0.95 (limit 0.9)"
    ]


@pytest.mark.parametrize(
    ("cause", "words"),
    [
        (FROZEN, "frozen: flow, 0.02 px (limit 0.1 px)"),
        (REVERSED, "reversed: odometry, -1 (limit 0)"),
        (("jump", "odometry", 100.0, 0.4), "jump: odometry, 100 m (limit 0.4 m)"),
        (("motionless", "odometry", 0.0, 0.2), "motionless: odometry, 0 (limit 0.2)"),
    ],
)
def test_an_input_that_contradicts_the_motion_is_told_at_once_and_so_are_retry_latch_and_end(
    cause: Cause, words: str
) -> None:
    told = Told()
    assert told.over(1.0, held(cause)) == [f"guard: the robot stands: {words}"]
    assert told.over(1.0, held(cause, may_move=True, may_advance=True)) == [
        f"guard: the robot retries, slowly: {words}"
    ]
    latched = held(cause, stopped=True)
    assert told.over(600.0, latched) == [f"guard: the robot stands until the guard is armed: {words}{ARM}"]
    assert told.over(5.0, replace(latched, overridden=True, may_move=True, may_advance=True, stopped=False)) == []
    (end,) = told.over(9.0, FREE)
    assert re.fullmatch(rf"guard: the robot may move again, after 60\d\.\d s: {cause[0]}", end)


def test_retries_without_end_are_told_as_often_as_their_number_doubles() -> None:
    told, lines = Told(), list[str]()
    for _ in range(100):
        lines += told.over(0.5, held(FROZEN, may_move=True, may_advance=True))
        lines += told.over(1.0, held(FROZEN, stopped=True))
    retries = [line for line in lines if "retries" in line]
    assert [int("".join(re.findall(r"\((\d+) times", line)) or 1) for line in retries] == [1, 2, 4, 8, 16, 32, 64]
    assert len(lines) == 14


def test_another_cause_within_a_stop_is_told_when_it_alone_holds_the_robot() -> None:
    told = Told()
    told.over(3.0, held(STALE))
    assert told.over(3.0, held(STALE, PLANE)) == []
    assert told.over(1.9, held(PLANE)) == []
    assert told.over(9.0, held(PLANE)) == ["guard: the robot stands: stale: plane, 0.85 s (limit 0.5 s)"]
    assert told.over(9.0, held(PLANE, FROZEN)) == [
        "guard: the robot stands: frozen: flow, 0.02 px (limit 0.1 px); stale: plane, 0.85 s (limit 0.5 s)"
    ]
    assert told.over(9.0, held(STOP, stopped=True)) == [
        f"guard: the robot stands until the guard is armed: stop: stop{ARM}"
    ]


def test_what_arms_the_guard_is_what_the_graph_wires(tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("graphs")
    (folder / "estop.yaml").write_text(
        "extends: navigate_live\ninputs: {operator.stop: {channel: ESTOP, type: graphnav_lcm.stop_t}}\n"
    )
    (folder / "hand.yaml").write_text(
        "extends: navigate_live\n"
        "inputs: {operator.stop: null, operator.twist: {channel: JOY, type: graphnav_lcm.twist_t}}\n"
        "stages: {guard: {in: {stop: null}}}\n"
    )
    (folder / "none.yaml").write_text(
        "extends: navigate_live\ninputs: {operator.stop: null, operator.twist: null}\n"
        "stages: {guard: {in: {stop: null, override: null}}}\n"
    )
    latched, elsewhere = held(FROZEN, stopped=True), "udpm://239.255.76.68:7668?ttl=1"
    remedies = [
        Told(str(folder / name), url).over(0.05, latched)[0].splitlines()[1]
        for name, url in (("estop.yaml", URL), ("estop.yaml", elsewhere), ("hand.yaml", URL), ("none.yaml", URL))
    ]
    assert remedies == [
        f"{ARM[1:]} --stop-channel ESTOP",
        f"{ARM[1:]} --stop-channel ESTOP --url '{elsewhere}'",
        "  look, then drive it by hand in: graphnav teleop --channel JOY",
        "  look, end the run, and start it again: its graph has no input by which an operator helps",
    ]


DRIVES_BLIND = """
inputs:
  camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}
  operator.stop: {channel: STOP, type: graphnav_lcm.stop_t}
stages:
  see: {use: probe.brightness, in: {image: camera.image}}
  flow: {use: flow.lucas_kanade, in: {image: camera.image}}
  guard:
    use: control.guard
    every_ms: 50
    with: {max_speed_mps: 0.3}
    in: {command: see.twist, flow: flow.flow, stop: operator.stop}
outputs: {guard.twist: {channel: BASE, motor: true}}
"""


def test_a_live_run_with_a_frozen_picture_tells_what_happens(live: Begin, outside: Program) -> None:
    program, run = outside("BASE"), live(DRIVES_BLIND)
    still = np.random.default_rng(0).integers(0, 255, (120, 160)).astype(np.uint8)

    def lines(begin: str = "guard: the robot ") -> Sequence[str]:
        return [line for line in run.notices if line.startswith(begin)]

    def is_latched() -> bool:
        program.say("CAMERA", Image(pixels=still))
        return bool(lines("guard: the robot stands until the guard is armed: frozen: flow, "))

    def waits() -> bool:
        return bool(lines("guard: the robot stands: waiting: command, "))

    program.wait_for(waits)
    program.wait_for(is_latched)
    begins = [line.split(":")[1].strip() for line in lines()]
    assert begins[-3:] == [
        "the robot stands",
        "the robot retries, slowly",
        "the robot stands until the guard is armed",
    ]
    summary, _ = run.stop()
    assert set(lines()) <= set(summary.notices)
