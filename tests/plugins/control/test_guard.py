"""The guard before the motors: what stops the robot, what lets it go on, what it says."""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from graphnav_control.guard import Guard, GuardOutputs

from graphnav import Age, FlowDeviation, Image, Latest, Plane, Stamp, Stop, Twist
from graphnav.testing import check_stage

PERIOD_US = 50_000
FRESH_S = 0.02
LATE_S = 0.6
COMMAND = Twist(v_mps=0.3, omega_radps=-0.4)
HAND = Twist(v_mps=-0.1, omega_radps=0.7)
ROWS, COLS = 30, 40


def plane(judged_ratio: float = 0.8, obstacle_ratio: float = 0.1) -> Plane:
    valid = (np.arange(ROWS * COLS) < judged_ratio * ROWS * COLS).astype(np.uint8).reshape(ROWS, COLS)
    return Plane(
        obstacle=np.zeros_like(valid),
        score=np.zeros(valid.shape, np.float32),
        valid=valid,
        step_px=4,
        obstacle_ratio=obstacle_ratio,
    )


def textured(noise: float = 0.0) -> Image:
    rng = np.random.default_rng(0)
    blocks = np.kron(rng.integers(60, 180, (12, 16)), np.ones((10, 10)))
    return Image(pixels=np.clip(blocks + noise * rng.standard_normal(blocks.shape), 0, 255).astype(np.uint8))


def flat(gray: float, noise: float = 0.0, shape: tuple[int, ...] = (120, 160)) -> Image:
    pixels = gray + noise * np.random.default_rng(0).standard_normal(shape)
    return Image(pixels=np.clip(pixels, 0, 255).astype(np.uint8))


def known(ratio: float) -> FlowDeviation:
    """Return the deviation of a flow that is known well in this share of the picture's middle."""
    deviation_px = np.full((ROWS, COLS), 5.0, np.float32)
    deviation_px[:, : round(ratio * COLS)] = 0.05
    return FlowDeviation(deviation_px=deviation_px, step_px=4)


def fresh(message: Any) -> Latest[Any]:
    return Latest(message, FRESH_S)


GOOD: dict[str, Any] = {
    "command": COMMAND,
    "plane": fresh(plane()),
    "image": fresh(textured()),
    "flow": Latest(is_connected=False),
    "deviation": Latest(is_connected=False),
    "motion": Latest(is_connected=False),
    "odometry": Latest(is_connected=False),
    "override": Latest(is_connected=False),
    "stop": Latest(is_connected=False),
    "command_age_s": Age(FRESH_S),
}


class Driven:
    """A guard that is fired every 50 ms, with good inputs except the given ones."""

    def __init__(self, **parameters: Any) -> None:
        self.guard = Guard(**parameters)
        self.guard.reset(seed=0)
        self.utime = 0

    def __call__(self, **inputs: Any) -> GuardOutputs:
        self.utime += PERIOD_US
        return self.guard.step(**{**GOOD, **inputs}, utime=Stamp(self.utime))


def causes(outputs: GuardOutputs) -> list[tuple[str, str]]:
    return list(zip(outputs.state.causes, outputs.state.ports, strict=True))


def speeds(outputs: GuardOutputs) -> tuple[float, float]:
    return outputs.twist.v_mps, outputs.twist.omega_radps


def test_it_keeps_the_contract_and_may_stand_before_motors() -> None:
    steps = [{**GOOD, "utime": Stamp(k * PERIOD_US), "command": command} for k, command in enumerate((COMMAND, None))]
    check_stage(Guard, *steps)
    assert Guard.is_guard


@pytest.mark.parametrize(
    "command", [COMMAND, HAND, Twist(v_mps=-0.0, omega_radps=1e-17), Twist(v_mps=7.1, omega_radps=9)]
)
def test_without_limits_and_causes_a_command_leaves_bit_for_bit(command: Twist) -> None:
    outputs = Driven()(command=command)
    assert [math.copysign(1.0, x) * abs(x) for x in speeds(outputs)] == [command.v_mps, command.omega_radps]
    assert np.array(speeds(outputs)).tobytes() == np.array([command.v_mps, command.omega_radps], float).tobytes()
    assert outputs.state.may_move
    assert outputs.state.may_advance
    assert not outputs.state.overridden
    assert not outputs.state.stopped
    assert causes(outputs) == []


@pytest.mark.parametrize(
    ("lost", "port"),
    [
        ({"command": None, "command_age_s": Age(math.inf)}, "command"),
        ({"plane": Latest()}, "plane"),
        ({"image": Latest()}, "image"),
    ],
)
def test_it_waits_for_every_wired_input(lost: dict[str, Any], port: str) -> None:
    guard = Driven()
    for waited_s in (0.0, 0.05, 0.1):
        outputs = guard(**lost)
        assert speeds(outputs) == (0.0, 0.0)
        assert not outputs.state.may_move
        assert not outputs.state.may_advance
        assert causes(outputs) == [("waiting", port)]
        assert outputs.state.values == pytest.approx([waited_s])
    assert speeds(guard()) == (0.3, -0.4)


def test_what_is_not_wired_is_not_waited_for() -> None:
    nothing: Latest[Any] = Latest(is_connected=False)
    assert speeds(Driven()(plane=nothing, image=nothing)) == (0.3, -0.4)


@pytest.mark.parametrize(
    ("late", "port"),
    [
        ({"command_age_s": Age(LATE_S)}, "command"),
        ({"plane": Latest(plane(), LATE_S)}, "plane"),
        ({"image": Latest(textured(), LATE_S)}, "image"),
    ],
)
def test_it_stops_for_what_is_too_old_and_goes_on_after_it(late: dict[str, Any], port: str) -> None:
    guard = Driven()
    assert speeds(guard()) == (0.3, -0.4)
    outputs = guard(**late)
    assert speeds(outputs) == (0.0, 0.0)
    assert causes(outputs) == [("stale", port)]
    assert outputs.state.values == pytest.approx([LATE_S])
    assert outputs.state.limits == pytest.approx([0.5])
    again = [guard() for _ in range(12)]
    assert [speeds(outputs) for outputs in again[:9]] == [(0.0, 0.0)] * 9
    assert speeds(again[-1]) == (0.3, -0.4)
    assert causes(again[0]) == [("stale", port)]
    assert again[0].state.values == pytest.approx([LATE_S])
    assert again[0].state.limits == pytest.approx([0.4])
    assert speeds(Driven(max_age_s=LATE_S)(**late)) == (0.3, -0.4)


@pytest.mark.parametrize("offset_s", [0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7])
def test_an_age_near_the_limit_does_not_make_the_robot_jerk(offset_s: float) -> None:
    guard, noise = Driven(), random.Random(1)
    moves, born_s = [], 0.0
    for k in range(200):
        if k % 2 == 0:  # images at 10 Hz, the guard at 20 Hz
            born_s = 0.05 * k - offset_s - noise.uniform(0.0, 0.03)
        moves.append(guard(image=Latest(textured(), 0.05 * k - born_s)).state.may_move)
    assert sum(a != b for a, b in itertools.pairwise(moves)) <= 2
    assert moves[-1] == (offset_s <= 0.4)


def test_an_input_that_is_always_near_the_limit_recovers() -> None:
    guard = Driven()
    guard(image=Latest(textured(), LATE_S))
    moves = [guard(image=Latest(textured(), 0.45)).state.may_move for _ in range(202)]
    assert not any(moves[:199])
    assert moves[-1]


@pytest.mark.parametrize(
    ("faulty", "port"),
    [
        ({"plane": Latest(plane(), FRESH_S, "the sender's clock jumped")}, "plane"),
        ({"image": Latest(textured(), FRESH_S, "the sender's clock jumped")}, "image"),
        ({"command": Twist(v_mps=math.nan, omega_radps=0.0)}, "command"),
        ({"command": Twist(v_mps=0.1, omega_radps=math.inf)}, "command"),
        ({"override": Latest(HAND, FRESH_S, "the sender's clock jumped")}, "override"),
        ({"override": Latest(Twist(v_mps=math.nan, omega_radps=0.0), FRESH_S)}, "override"),
    ],
)
def test_it_stops_for_what_cannot_be_right(faulty: dict[str, Any], port: str) -> None:
    outputs = Driven()(**faulty)
    assert speeds(outputs) == (0.0, 0.0)
    assert not outputs.state.may_move
    assert causes(outputs) == [("fault", port)]


def test_every_cause_is_named() -> None:
    outputs = Driven()(
        command=None,
        command_age_s=Age(math.inf),
        plane=Latest(plane(), LATE_S, "stamps repeat"),
        image=fresh(flat(255)),
        stop=fresh(Stop(engaged=True)),
    )
    expected = [("stop", "stop"), ("waiting", "command"), ("stale", "plane"), ("fault", "plane"), ("blind", "image")]
    assert causes(outputs) == expected
    assert len(outputs.state.values) == len(outputs.state.limits) == len(expected)
    assert outputs.state.not_finite() is None


def test_unknown_is_not_free() -> None:
    outputs = Driven(unjudged="ignore")(plane=fresh(plane(judged_ratio=0.1)))
    assert speeds(outputs) == (0.0, 0.0)
    assert causes(outputs) == [("blind", "plane")]
    assert outputs.state.values == pytest.approx([0.1])
    assert outputs.state.limits == pytest.approx([0.5])
    guard = Driven(min_judged_ratio=0.0, unjudged="ignore")
    assert speeds(guard(plane=fresh(plane(judged_ratio=0.0)))) == (0.3, -0.4)


def before_a_wall(unknown_ratio: float = 0.3) -> Plane:
    """Return a plane whose upper rows were not judged, as before a white wall; 20 of its rows are inside the rim."""
    seen = plane(1.0)
    seen.valid[: 5 + round(unknown_ratio * 20)] = 0
    return seen


@pytest.mark.parametrize(
    ("parameters", "allowed", "may"),
    [
        ({}, (0.0, -0.4), (True, False)),
        ({"unjudged": "obstacle"}, (0.0, -0.4), (True, False)),
        ({"unjudged": "hold"}, (0.0, 0.0), (False, False)),
        ({"unjudged": "brake"}, (0.3 * 0.3, -0.4), (True, True)),
        ({"unjudged": "brake", "unknown_speed_ratio": 0.5}, (0.15, -0.4), (True, True)),
    ],
)
def test_unknown_cells_ahead_forbid_to_go_forward(
    parameters: dict[str, Any], allowed: tuple[float, float], may: tuple[bool, bool]
) -> None:
    outputs = Driven(**parameters)(plane=fresh(before_a_wall()))
    assert speeds(outputs) == pytest.approx(allowed)
    assert (outputs.state.may_move, outputs.state.may_advance) == may
    assert causes(outputs) == [("unknown", "plane")]
    assert outputs.state.values == pytest.approx([0.3])
    assert outputs.state.limits == pytest.approx([0.1])


def test_few_unknown_cells_and_the_rim_forbid_nothing() -> None:
    assert speeds(Driven()(plane=fresh(before_a_wall(0.1)))) == (0.3, -0.4)
    assert speeds(Driven(max_unknown_ratio=0.3)(plane=fresh(before_a_wall()))) == (0.3, -0.4)
    assert causes(Driven(rim_ratio=0.4)(plane=fresh(before_a_wall()))) == []
    assert causes(Driven(unjudged="ignore")(plane=fresh(before_a_wall()))) == []


@pytest.mark.parametrize("unjudged", ["obstacle", "brake"])
def test_before_unknown_cells_the_robot_may_turn_and_back_off(unjudged: str) -> None:
    assert speeds(Driven(unjudged=unjudged)(plane=fresh(before_a_wall()), command=HAND)) == (-0.1, 0.7)


def test_obstacles_forbid_what_unknown_cells_only_brake() -> None:
    both = replace(before_a_wall(), obstacle_ratio=0.99)
    outputs = Driven(unjudged="brake")(plane=fresh(both))
    assert speeds(outputs) == (0.0, -0.4)
    assert causes(outputs) == [("unknown", "plane"), ("obstacle", "plane")]


@pytest.mark.parametrize("noise", [0.0, 2.0, 8.0])
@pytest.mark.parametrize("gray", [0, 12, 128, 255])
@pytest.mark.parametrize("shape", [(120, 160), (480, 640), (120, 160, 3)])
def test_an_image_that_shows_nothing_is_blind(gray: int, noise: float, shape: tuple[int, ...]) -> None:
    outputs = Driven()(image=fresh(flat(gray, noise, shape)))
    assert speeds(outputs) == (0.0, 0.0)
    assert causes(outputs) == [("blind", "image")]


def test_an_image_with_texture_is_seen_through_noise_and_in_colour() -> None:
    gray = textured(noise=20.0)
    colour = Image(pixels=np.repeat(gray.pixels[..., None], 3, axis=-1))
    assert causes(Driven()(image=fresh(gray))) == causes(Driven()(image=fresh(colour))) == []
    assert causes(Driven(min_contrast_gray=0.0)(image=fresh(flat(255)))) == []


def test_flow_that_is_not_known_well_stops_the_robot() -> None:
    outputs = Driven()(deviation=fresh(known(0.3)))
    assert speeds(outputs) == (0.0, 0.0)
    assert causes(outputs) == [("confused", "deviation")]
    assert outputs.state.described() == ["confused: deviation, 0.233 (limit 0.5)"]
    assert causes(Driven()(deviation=fresh(known(0.9)))) == []
    assert causes(Driven(min_known_ratio=0.1)(deviation=fresh(known(0.3)))) == []
    assert causes(Driven(max_deviation_px=6.0)(deviation=fresh(known(0.0)))) == []


def test_confusion_holds_the_robot_for_a_second_and_the_fourth_in_20_s_for_good() -> None:
    driven, well, badly = Driven(), fresh(known(1.0)), fresh(known(0.1))

    def stands_s() -> float:
        """Confuse it once; return for how long it stands after that, at most 5 s."""
        driven(deviation=badly)
        return next((k * 0.05 for k in range(100) if not causes(driven(deviation=well))), math.inf)

    for _ in range(3):
        assert 0.9 <= stands_s() <= 1.0
    assert stands_s() == math.inf
    state = driven(deviation=well).state
    assert state.stopped
    assert not state.may_move
    driven(deviation=well, stop=fresh(Stop(engaged=False)))
    assert causes(driven(deviation=well)) == []
    driven(deviation=badly)
    assert causes(driven(deviation=well, override=fresh(HAND))) == [("confused", "deviation")]


def test_a_wired_deviation_that_is_lost_stops_the_robot() -> None:
    assert causes(Driven()(deviation=Latest(known(1.0), LATE_S))) == [("stale", "deviation")]
    empty = FlowDeviation(deviation_px=np.empty((0, 0), np.float32))
    assert causes(Driven()(deviation=fresh(empty))) == [("confused", "deviation")]


def test_all_round_obstacle_forbids_going_forward_but_not_turning() -> None:
    blocked = {"plane": fresh(plane(obstacle_ratio=0.99))}
    outputs = Driven()(**blocked)
    assert speeds(outputs) == (0.0, -0.4)
    assert outputs.state.may_move
    assert not outputs.state.may_advance
    assert causes(outputs) == [("obstacle", "plane")]
    assert speeds(Driven()(**blocked, command=HAND)) == (-0.1, 0.7)
    assert speeds(Driven(max_obstacle_ratio=1.0)(**blocked)) == (0.3, -0.4)
    on_the_spot = Twist(v_mps=0.3 * math.cos(math.pi / 2), omega_radps=1.2)
    assert speeds(Driven()(**blocked, command=on_the_spot)) == (on_the_spot.v_mps, 1.2)


@pytest.mark.parametrize(
    "lost",
    [
        {},
        {"command": None, "command_age_s": Age(math.inf)},
        {"plane": Latest(), "image": Latest()},
        {"image": Latest(flat(255), LATE_S, "stamps repeat"), "plane": fresh(plane(0.0))},
        {"plane": fresh(plane(obstacle_ratio=1.0))},
        {"plane": fresh(plane(judged_ratio=0.6))},
    ],
)
def test_a_fresh_override_drives_whatever_else_comes(lost: dict[str, Any]) -> None:
    guard = Driven()
    without = guard(**lost)
    outputs = guard(**lost, override=fresh(HAND))
    assert speeds(outputs) == (-0.1, 0.7)
    assert outputs.state.overridden
    assert outputs.state.may_move
    assert outputs.state.may_advance
    assert causes(outputs) == causes(without)
    assert speeds(guard(**lost, override=Latest(HAND, 0.31))) == speeds(without)


def drivers(ages_s: Iterable[float], guard: Driven | None = None) -> list[str]:
    """Return who drives, at firings every 50 ms with overrides of these ages: the operator, the command, or none."""
    guard = guard or Driven()
    who = {(-0.1, 0.7): "operator", (0.3, -0.4): "command", (0.0, 0.0): "none"}
    return [who[speeds(guard(override=Latest(HAND, age_s)))] for age_s in ages_s]


@pytest.mark.parametrize("sawtooth", [False, True], ids=["delayed", "slow"])
def test_operator_and_command_do_not_take_turns_where_the_age_of_an_override_is_near_its_limit(sawtooth: bool) -> None:
    noise = random.Random(1)
    ages_s = [0.05 * (k % 7) + 0.01 if sawtooth else 0.3 + noise.uniform(-0.03, 0.03) for k in range(200)]
    who = drivers(ages_s)
    assert sum(a != b for a, b in itertools.pairwise(who)) <= 3
    assert who[-150:] == ["none"] * 150


def test_an_unreliable_override_is_named_and_ends_or_recovers() -> None:
    guard = Driven()
    assert drivers([0.05, 0.31, 0.05], guard) == ["operator", "command", "none"]
    state = guard(override=Latest(HAND, 0.29)).state
    assert causes(GuardOutputs(HAND, state)) == [("stale", "override")]
    assert state.values == pytest.approx([0.29])
    assert state.limits == pytest.approx([0.24])
    recovered = drivers([0.05] * 9, guard)
    assert recovered[:5] + recovered[7:] == ["none"] * 5 + ["operator"] * 2
    assert drivers([0.31, 0.59, 0.61, 0.05], guard) == ["command", "command", "command", "operator"]
    assert drivers([0.31, 0.05, 0.31, 0.59, 0.61], guard) == ["command", "none", "none", "none", "command"]


def test_an_override_that_stands_still_holds_the_robot() -> None:
    outputs = Driven()(override=fresh(Twist(v_mps=0.0, omega_radps=0.0)))
    assert speeds(outputs) == (0.0, 0.0)
    assert outputs.state.overridden


def test_a_stop_holds_against_everything_until_a_fresh_message_arms_the_guard() -> None:
    guard = Driven()
    engaged, armed = Stop(engaged=True, reason="a person in the way"), Stop(engaged=False)
    for stop in (
        Latest(engaged, FRESH_S),
        Latest(engaged, 100.0),
        Latest(is_connected=True),
        Latest(armed, LATE_S),
        Latest(armed, FRESH_S, "stamps repeat"),
    ):
        outputs = guard(stop=stop, override=fresh(HAND))
        assert speeds(outputs) == (0.0, 0.0)
        assert outputs.state.stopped
        assert not outputs.state.may_move
        assert not outputs.state.overridden
        assert causes(outputs) == [("stop", "stop")]
    assert speeds(guard(stop=fresh(armed))) == (0.3, -0.4)
    assert speeds(guard(stop=Latest(armed, 100.0))) == (0.3, -0.4)


def test_a_stop_that_came_late_is_obeyed() -> None:
    assert speeds(Driven()(stop=Latest(Stop(engaged=True), 100.0))) == (0.0, 0.0)


def test_a_reset_arms_the_guard() -> None:
    guard = Driven()
    guard(stop=fresh(Stop(engaged=True)))
    guard.guard.reset(seed=0)
    assert speeds(guard()) == (0.3, -0.4)


def test_limits_hold_to_both_sides() -> None:
    guard = Driven(max_speed_mps=0.2, max_turn_radps=0.3)
    assert speeds(guard()) == (0.2, -0.3)
    assert speeds(guard(command=Twist(v_mps=-0.5, omega_radps=0.1))) == (-0.2, 0.1)
    assert speeds(guard(override=fresh(HAND))) == (-0.1, 0.3)


def test_ramps_hold_where_the_robot_speeds_up_and_never_delay_a_stop() -> None:
    guard = Driven(max_accel_mps2=1.0, max_turn_accel_radps2=4.0)
    ahead, back = Twist(v_mps=0.3, omega_radps=0.5), Twist(v_mps=-0.3, omega_radps=-0.5)
    driven = [speeds(guard(command=ahead)) for _ in range(8)]
    assert [v for v, _ in driven] == pytest.approx([0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.3])
    assert [omega for _, omega in driven] == pytest.approx([0.0, 0.2, 0.4, 0.5, 0.5, 0.5, 0.5, 0.5])
    assert speeds(guard(command=Twist(v_mps=0.1, omega_radps=0.2))) == (0.1, 0.2)
    assert speeds(guard(command=back)) == pytest.approx((-0.05, -0.2))
    assert speeds(guard(image=Latest(textured(), FRESH_S, "stamps repeat"))) == (0.0, 0.0)
    assert speeds(guard(command=ahead)) == pytest.approx((0.05, 0.2))
    assert speeds(guard(stop=fresh(Stop(engaged=True)))) == (0.0, 0.0)


def test_a_long_pause_between_firings_is_no_run_up() -> None:
    guard = Driven(max_accel_mps2=0.1)
    guard()
    guard.utime += 3_600_000_000
    assert guard().twist.v_mps == pytest.approx(0.1 * 0.5)


def test_its_clock_may_stand_still() -> None:
    guard = Driven(max_accel_mps2=1.0)
    guard()
    guard.utime -= PERIOD_US
    assert guard().twist.v_mps == 0.0


def test_inputs_are_not_remembered() -> None:
    guard = Driven()
    guard()
    assert causes(guard(plane=replace(GOOD["plane"], value=plane(0.0)))) == [
        ("blind", "plane"),
        ("unknown", "plane"),
    ]
    assert causes(guard()) == []
