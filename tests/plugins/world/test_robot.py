"""The world as a robot on a bus: rates, stamps, commands, endings."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_world.robot import Robot, RobotOutputs
from graphnav_world.world import Pymunk

from graphnav import Finished, Latest, ParamError, Stamp, Twist
from graphnav.testing import check_stage

STEP_US = 10_000
SMALL: dict[str, Any] = {"size": (32, 24)}
EXACT: dict[str, Any] = {"odometry_scale_ratio": 0.0, "odometry_noise_ratio": 0.0}
QUICK: dict[str, Any] = {"speed_up_s": 1e-6, "turn_up_s": 1e-6}
AHEAD, CURVE = Twist(v_mps=0.4, omega_radps=0.0), Twist(v_mps=0.4, omega_radps=0.7)
REGULAR = range(0, 3_000_000, STEP_US)
IRREGULAR = np.cumsum([7_000_000, *np.random.default_rng(5).choice([4_000, 9_000, 11_000, 35_000, 160_000], 150)])
Steps = list[tuple[int, RobotOutputs]]


def drive(
    robot: Robot, twist: Twist | None, stamps: Iterable[int] = REGULAR, seed: int = 3, age_s: float = 0.01
) -> tuple[Steps, str]:
    """Return stamps and outputs of a drive, and how it ended."""
    robot.reset(seed)
    command: Latest[Twist] = Latest() if twist is None else Latest(twist, age_s)
    steps: Steps = []
    for stamp in map(int, stamps):
        try:
            steps.append((stamp, robot.step(command, Stamp(stamp))))
        except Finished as end:
            return [*steps, (stamp, end.outputs)], end.outcome
    return steps, "timeout"


def of(steps: Steps, port: str) -> list[tuple[int, Any]]:
    """Return the stamps and messages of one port."""
    return [(stamp, message) for stamp, outputs in steps if (message := getattr(outputs, port)) is not None]


def test_every_sensor_has_its_rate(maps: Path) -> None:
    steps, _ = drive(Robot(map=maps / "corridor_ccw.yaml", **SMALL), None)
    stamps = {port: [stamp for stamp, _ in of(steps, port)] for port in RobotOutputs._fields}
    assert stamps["image"] == list(range(0, 3_000_000, 100_000))
    assert stamps["truth"] == stamps["image"][1:]
    assert stamps["state"] == list(range(0, 3_000_000, 50_000))
    assert stamps["goal"] == list(range(0, 3_000_000, 200_000))
    assert stamps["map"] == [0, 2_000_000]
    assert len(stamps["odometry"]) == pytest.approx(150, abs=1)


def test_the_first_step_has_everything_but_truth(maps: Path) -> None:
    (_, first), *_ = drive(Robot(map=maps / "corridor_ccw.yaml", **SMALL), None, [5_000_000])[0]
    assert first.truth is None
    assert None not in (first.image, first.state, first.goal, first.map)
    assert first.odometry is not None
    read = first.odometry.message
    assert (first.odometry.utime, read.x_m, read.y_m, read.yaw_rad) == (5_000_000, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("stamps", [REGULAR, IRREGULAR], ids=["regular", "irregular"])
def test_odometry_samples_the_pose_at_its_own_stamps(stamps: Iterable[int], maps: Path) -> None:
    steps, _ = drive(Robot(map=maps / "empty.yaml", **SMALL, **EXACT, **QUICK), CURVE, stamps)
    begin_us, radius_m, off_us = steps[0][0], 0.4 / 0.7, []
    before_us = begin_us - STEP_US
    for now_us, sample in of(steps, "odometry"):
        read, angle = sample.message, 0.7 * (sample.utime - begin_us) / 1e6
        assert (read.x_m, read.y_m) == pytest.approx(
            (radius_m * math.sin(angle), radius_m * (1 - math.cos(angle))), abs=1e-4
        )
        assert math.remainder(read.yaw_rad - angle, 2 * math.pi) == pytest.approx(0.0, abs=1e-8)
        assert before_us < sample.utime <= now_us
        before_us = sample.utime
        off_us.append((sample.utime - begin_us + 10_000) % 20_000 - 10_000)
    assert np.abs(off_us).max() <= 4_000
    assert np.std(off_us) > 1_500


def test_a_sample_is_published_at_the_first_step_at_or_after_it(maps: Path) -> None:
    steps, _ = drive(Robot(map=maps / "empty.yaml", **SMALL), CURVE)
    for now_us, sample in of(steps, "odometry"):
        assert now_us - STEP_US < sample.utime <= now_us


def test_after_a_long_step_only_the_newest_samples_are_left(maps: Path) -> None:
    stamps = [0, 10_000, 1_010_000, 1_020_000, 1_030_000, 1_040_000]
    steps, _ = drive(Robot(map=maps / "empty.yaml", **SMALL, odometry_jitter_s=0.0), CURVE, stamps)
    assert [sample.utime for _, sample in of(steps, "odometry")] == [0, 980_000, 1_000_000, 1_020_000, 1_040_000]


@pytest.mark.parametrize("stamps", [REGULAR, IRREGULAR], ids=["regular", "irregular"])
def test_truth_covers_the_time_since_the_last_image(stamps: Iterable[int], maps: Path) -> None:
    robot = Robot(map=maps / "empty.yaml", size=(80, 60), tilt_deg=90.0, state_hz=100.0, **QUICK)
    steps, _ = drive(robot, AHEAD, stamps)
    images, truths = of(steps, "image"), of(steps, "truth")
    assert [stamp for stamp, _ in truths] == [stamp for stamp, _ in images[1:]]
    for (before_us, _), (now_us, truth) in zip(images, truths, strict=False):
        assert truth.interval_us == now_us - before_us
        way_px = 40 / math.tan(math.radians(35)) * 0.4 * truth.interval_us / 1e6
        assert truth.flow_px[..., 1].mean() == pytest.approx(way_px, abs=0.02)


def test_a_late_step_takes_one_image(maps: Path) -> None:
    stamps = [0, 10_000, 350_000, 360_000, 390_000, 401_000, 410_000, 500_000]
    steps, _ = drive(Robot(map=maps / "empty.yaml", **SMALL), AHEAD, stamps)
    assert [stamp for stamp, _ in of(steps, "image")] == [0, 350_000, 401_000, 500_000]


def test_images_jitter_where_that_is_asked_for(maps: Path) -> None:
    steps, _ = drive(Robot(map=maps / "empty.yaml", **SMALL, image_jitter_s=0.03), AHEAD)
    stamps = np.array([stamp for stamp, _ in of(steps, "image")])
    off_us = stamps - 100_000 * np.arange(len(stamps))
    assert off_us.min() < -10_000
    assert off_us.max() > 10_000
    assert off_us.max() <= 30_000 + STEP_US


def test_truth_can_be_left_out_and_changes_no_image(maps: Path) -> None:
    full, bare = (drive(Robot(map=maps / "crossing.yaml", truth=t, **SMALL), AHEAD)[0] for t in (True, False))
    assert of(full, "truth")
    assert not of(bare, "truth")
    for (_, one), (_, other) in zip(of(full, "image"), of(bare, "image"), strict=True):
        assert np.array_equal(one.pixels, other.pixels)


def test_sensors_do_not_change_the_drive(maps: Path) -> None:
    one = Robot(map=maps / "corridor_ccw.yaml", **SMALL, state_hz=100.0)
    other = Robot(map=maps / "corridor_ccw.yaml", **SMALL, state_hz=100.0, image_hz=30.0, odometry_hz=20.0)
    paths = [[(s.x_m, s.y_m, s.yaw_rad) for _, s in of(drive(robot, CURVE)[0], "state")] for robot in (one, other)]
    assert paths[0] == paths[1]


def test_it_draws_the_same_world_as_pymunk(maps: Path) -> None:
    robot, world = Robot(map=maps / "corridor_ccw.yaml"), Pymunk(map=maps / "corridor_ccw.yaml")
    (_, first), *_ = drive(robot, None, [0], seed=11)[0]
    world.reset(11)
    other = world.step(Latest(), Stamp(0))
    assert first.image is not None
    assert np.array_equal(first.image.pixels, other.image.pixels)
    assert first.map is not None
    assert other.map is not None
    assert np.array_equal(first.map.vertices_m, other.map.vertices_m)


def test_it_stands_until_a_command_comes_and_after_it_is_too_old(maps: Path) -> None:
    robot = Robot(map=maps / "empty.yaml", **SMALL, state_hz=100.0)
    robot.reset(3)
    speeds = {}
    for now_us in range(0, 2_000_000, STEP_US):
        age_s = (now_us - 295_000) / 1e6
        out = robot.step(Latest(AHEAD, age_s) if age_s > 0 else Latest(), Stamp(now_us))
        assert out.state is not None
        speeds[now_us] = out.state.v_mps
    assert speeds[300_000] == 0.0
    assert speeds[310_000] == pytest.approx(0.02), "it acts from the step after its arrival"
    assert speeds[790_000] == 0.4
    assert 0.0 < speeds[810_000] < 0.4, "it brakes from 795 ms on, within a step of 10 ms"
    assert speeds[795_000 + 205_000 + STEP_US - 10_000] == 0.0
    assert speeds[1_990_000] == 0.0


def test_a_world_obeys_no_command_that_is_too_old(maps: Path) -> None:
    for timeout_s, moves in ((None, True), (0.5, False), (1.0, True)):
        world = Pymunk(map=maps / "empty.yaml", command_timeout_s=timeout_s, **SMALL)
        world.reset(3)
        out = [world.step(Latest(AHEAD, 0.7), Stamp(k * 100_000)) for k in range(3)][-1]
        assert (out.state.v_mps > 0.0) is moves


@pytest.mark.parametrize("ends", [True, False])
def test_a_contact_ends_the_run_or_the_drive(ends: bool, maps: Path) -> None:
    robot = Robot(map=maps / "corridor_ccw.yaml", **SMALL, ends=ends)
    steps, outcome = drive(robot, AHEAD, range(0, 15_000_000, STEP_US))
    assert outcome == ("contact" if ends else "timeout")
    states = of(steps, "state")
    contact = next(k for k, (_, state) in enumerate(states) if state.contact)
    assert states[contact][1].clearance_m == 0.0
    assert ends == (contact == len(states) - 1)
    last = states[-1][1]
    assert (last.x_m, last.v_mps) == (states[contact][1].x_m, 0.0)


@pytest.mark.parametrize("ends", [True, False])
def test_the_goal_ends_the_run_or_the_drive(ends: bool, tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text("start: {at_m: [0, 0], heading_deg: 90}\ngoal: {circle: {center_m: [0, 2], radius_m: 0.5}}\n")
    robot = Robot(map=path, **SMALL, ends=ends)
    steps, outcome = drive(robot, AHEAD, range(0, 6_000_000, STEP_US))
    assert outcome == ("goal" if ends else "timeout")
    reached_us, reached = next((stamp, state) for stamp, state in of(steps, "state") if state.at_goal)
    assert reached.y_m == pytest.approx(1.5, abs=0.011), "seen at the first step in the goal, whatever state_hz is"
    last = steps[-1][1].state or of(steps, "state")[-1][1]
    assert (last.v_mps == 0.0) is not ends
    assert last.y_m < 1.5 + 0.05
    assert ends == (reached_us == steps[-1][0])


def test_clearance_is_the_minimum_since_the_last_state(maps: Path) -> None:
    often, rarely = (
        [state.clearance_m for _, state in of(drive(robot, CURVE, range(0, 1_000_001, STEP_US))[0], "state")]
        for robot in (Robot(map=maps / "corridor_ccw.yaml", state_hz=hz, **SMALL) for hz in (100.0, 5.0))
    )
    minima = [min(often[max(0, k - 19) : k + 1]) for k in range(0, 101, 20)]
    assert rarely == pytest.approx(minima, abs=1e-12)


def test_the_same_seed_commands_and_stamps_give_the_same_bytes() -> None:
    steps = [{"command": Latest(CURVE, 0.02), "utime": Stamp(int(stamp))} for stamp in IRREGULAR[:40]]
    check_stage(Robot, *steps, map="maps/corridor_ccw.yaml", **SMALL)


@pytest.mark.parametrize(
    ("params", "param", "said"),
    [
        ({"image_hz": 200.0}, "image_hz", "'image_hz' is 200, but the physics steps only 100 times a second"),
        ({"rate_hz": 30.0}, "odometry_hz", "'odometry_hz' is 50, but the physics steps only 30 times a second"),
        ({"odometry_jitter_s": 0.01}, "odometry_jitter_s", "must be less than half of the period of 0.02 s"),
        ({"image_jitter_s": 0.06}, "image_jitter_s", "must be less than half of the period of 0.1 s"),
    ],
)
def test_rates_that_do_not_fit_are_shown_at_their_parameter(
    params: dict[str, Any], param: str, said: str, maps: Path
) -> None:
    with pytest.raises(ExceptionGroup) as caught:
        Robot(map=maps / "empty.yaml", **params).check()
    first = caught.value.exceptions[0]
    assert isinstance(first, ParamError)
    assert first.param == param
    assert said in str(first)
