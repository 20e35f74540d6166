"""The motion of a frame from odometry at another rate: exact on arcs, nothing where the samples do not tell."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np
import pytest
from graphnav_odometry.motion import Motion
from graphnav_odometry.pose import Pose, arc, part_of_arc
from graphnav_odometry.track import KEPT_US, MAX_SAMPLES, Track
from hypothesis import given
from hypothesis import strategies as st

import graphnav
from graphnav import Flow, Odometry, Since, Stamp
from graphnav.testing import check_stage

FRAME_US = 100_000
SAMPLE_US = 20_000
START_US = 1_700_000_000_000_000
Way = Callable[[int], Odometry]
Sample = tuple[int, Odometry]


def drive(v_mps: float, omega_radps: float, yaw_rad: float = 0.3) -> Way:
    """Return the odometry of a drive of constant speeds, by the time since its start, microseconds."""

    def at(us: int) -> Odometry:
        seconds = us * 1e-6
        begin = Pose(3.0, -2.0, yaw_rad)
        pose = begin.then(arc(v_mps * seconds, 0.0, omega_radps * seconds))
        wrapped = math.remainder(pose.yaw_rad, 2 * math.pi)
        return Odometry(x_m=pose.x_m, y_m=pose.y_m, yaw_rad=wrapped, v_mps=v_mps, omega_radps=omega_radps)

    return at


def samples(way: Way, times_us: Iterable[int]) -> tuple[Sample, ...]:
    return tuple((START_US + us, way(us)) for us in times_us)


def flow(interval_us: int = FRAME_US) -> Flow:
    return Flow(uv_px=np.zeros((3, 4, 2), np.float32), valid=np.ones((3, 4), np.uint8), interval_us=interval_us)


def started(**parameters: float) -> Motion:
    stage = Motion(**parameters)
    stage.reset(seed=0)
    return stage


def motion(given: Iterable[Sample], at_us: int, interval_us: int = FRAME_US, **parameters: float) -> graphnav.Motion:
    """Return the motion of the interval that ends at this time, which there must be."""
    found = none_or_motion(given, at_us, interval_us, **parameters)
    assert found is not None
    return found


def none_or_motion(
    given: Iterable[Sample], at_us: int, interval_us: int = FRAME_US, **parameters: float
) -> graphnav.Motion | None:
    return started(**parameters).step(flow(interval_us), Since(tuple(given)), Stamp(START_US + at_us)).motion


def expect_arc(found: graphnav.Motion, v_mps: float, omega_radps: float, interval_us: int = FRAME_US) -> None:
    seconds = interval_us * 1e-6
    end = arc(v_mps * seconds, 0.0, omega_radps * seconds)
    assert found.forward_m == pytest.approx(end.x_m, abs=1e-9)
    assert found.left_m == pytest.approx(end.y_m, abs=1e-9)
    assert found.turn_rad == pytest.approx(end.yaw_rad, abs=1e-9)
    assert found.interval_us == interval_us


REGULAR = range(0, 400_000, SAMPLE_US)


@pytest.mark.parametrize("omega_radps", [0.0, 1e-7, 0.5, -1.2, 9.0])
@pytest.mark.parametrize("v_mps", [0.0, 0.3, -0.2])
@pytest.mark.parametrize("yaw_rad", [0.0, 3.1, -2.0])
def test_an_arc_is_exact_at_any_stamps(v_mps: float, omega_radps: float, yaw_rad: float) -> None:
    jitter = np.random.default_rng(1).integers(-9000, 9000, len(REGULAR))
    stamps = [int(us + j) for us, j in zip(REGULAR, jitter, strict=True)]
    for at_us, interval_us in ((213_456, FRAME_US), (300_001, 250_000), (SAMPLE_US * 12, 33_333)):
        found = motion(samples(drive(v_mps, omega_radps, yaw_rad), stamps), at_us, interval_us)
        expect_arc(found, v_mps, omega_radps, interval_us)


def test_frames_at_the_stamps_of_samples_need_no_interpolation() -> None:
    given = samples(drive(0.3, 0.7), range(0, 120_000, SAMPLE_US))
    expect_arc(motion(given, 100_000), 0.3, 0.7)


def test_samples_are_kept_from_frame_to_frame() -> None:
    stage, way = started(), drive(0.3, -0.9)
    for frame in range(1, 200):
        now_us = frame * FRAME_US + 7
        new = range((frame - 1) * FRAME_US, frame * FRAME_US, SAMPLE_US)
        given = Since(samples(way, [us + SAMPLE_US for us in new]))
        found = stage.step(flow(), given, Stamp(START_US + now_us - 50)).motion
        if frame == 1:
            assert found is None  # the samples do not reach back to the frame before
        else:
            assert found is not None
            expect_arc(found, 0.3, -0.9)


def test_the_motion_is_that_of_the_flow_not_that_since_the_last_firing() -> None:
    stage, way = started(), drive(0.4, 0.2)
    stage.step(flow(), Since(samples(way, range(0, 220_000, SAMPLE_US))), Stamp(START_US + 200_000))
    overtaken = Since(samples(way, range(220_000, 720_000, SAMPLE_US)))
    found = stage.step(flow(), overtaken, Stamp(START_US + 700_000)).motion
    assert found is not None
    expect_arc(found, 0.4, 0.2)


@pytest.mark.parametrize(
    "times_us",
    [
        [],
        [200_000],
        range(120_000, 400_000, SAMPLE_US),  # begins after the frame before
        range(0, 200_000, SAMPLE_US),  # ends before the frame
    ],
)
def test_no_motion_where_the_samples_do_not_cover_the_interval(times_us: Iterable[int]) -> None:
    assert none_or_motion(samples(drive(0.3, 0.0), times_us), 200_000) is None


def test_speeds_may_be_trusted_beyond_the_last_sample() -> None:
    given = samples(drive(0.3, 0.8), range(0, 200_000, SAMPLE_US))
    expect_arc(motion(given, 195_000, max_extrapolation_s=0.02), 0.3, 0.8)
    assert none_or_motion(given, 205_000, max_extrapolation_s=0.02) is None
    expect_arc(motion(given, 190_000, interval_us=7_000, max_extrapolation_s=0.02), 0.3, 0.8, 7_000)


@pytest.mark.parametrize(("gone", "is_bridged"), [(2, True), (3, False), (6, False)])
def test_a_gap_of_more_than_three_periods_is_not_bridged(gone: int, is_bridged: bool) -> None:
    missing = range(140_000, 140_000 + gone * SAMPLE_US, SAMPLE_US)
    given = samples(drive(0.3, 0.4), [us for us in range(0, 600_000, SAMPLE_US) if us not in missing])
    found = none_or_motion(given, 200_000)
    assert (found is not None) == is_bridged
    if found is not None:
        expect_arc(found, 0.3, 0.4)
    expect_arc(motion(given, 500_000), 0.3, 0.4)  # after the gap


def test_a_pause_before_the_drive_is_not_bridged() -> None:
    given = samples(drive(0.3, 0.0), [0, 10_000_000, 10_020_000, 10_040_000, 10_060_000])
    assert none_or_motion(given, 10_030_000) is None


@pytest.mark.parametrize("jump", [Pose(1.0, 0.0, 0.0), Pose(0.0, 0.0, 2.0)])
def test_a_jump_of_the_pose_gives_no_motion_where_it_lies(jump: Pose) -> None:
    way = drive(0.3, 0.4)

    def reset(us: int) -> Odometry:
        sample = way(us)
        if us < 150_000:
            return sample
        return Odometry(
            x_m=sample.x_m + jump.x_m,
            y_m=sample.y_m + jump.y_m,
            yaw_rad=sample.yaw_rad + jump.yaw_rad,
            v_mps=sample.v_mps,
            omega_radps=sample.omega_radps,
        )

    given = samples(reset, REGULAR)
    assert none_or_motion(given, 200_000) is None
    for at_us in (120_000, 300_000):
        assert motion(given, at_us).turn_rad == pytest.approx(0.04)
    assert none_or_motion(given, 200_000, max_speed_mps=1000.0, max_turn_radps=1000.0) is not None


def test_stamps_that_nearly_meet_are_no_jump() -> None:
    way = drive(4.0, 0.0)
    given = [(START_US + us - (us % 40_000) // 21, way(us)) for us in REGULAR]
    assert none_or_motion(given, 200_000) is not None


def test_samples_out_of_order_and_repeated_are_dropped() -> None:
    ordered = samples(drive(0.3, 0.5), REGULAR)
    wrong = Odometry(x_m=99.0, y_m=0.0, yaw_rad=0.0, v_mps=0.0, omega_radps=0.0)
    given = [*ordered[:8], (ordered[7][0], wrong), (ordered[3][0] + 1, wrong), *ordered[8:]]
    expect_arc(motion(given, 200_000), 0.3, 0.5)


def test_a_clock_that_was_set_back_restarts_the_track() -> None:
    stage, way = started(), drive(0.3, 0.5)
    hour_us = 3_600_000_000
    ahead = tuple((sent + hour_us, sample) for sent, sample in samples(way, REGULAR))
    assert stage.step(flow(), Since(ahead), Stamp(START_US + 300_000)).motion is None
    back = Since(samples(way, range(400_000, 700_000, SAMPLE_US)))
    found = stage.step(flow(), back, Stamp(START_US + 600_000)).motion
    assert found is not None
    expect_arc(found, 0.3, 0.5)


def test_a_flood_of_samples_is_bounded() -> None:
    track, way = Track(5.0, 20.0), drive(0.3, 0.5)
    for us in range(0, 4 * MAX_SAMPLES * 50, 50):
        track.add(us, way(us))
    assert len(track._stamps) <= MAX_SAMPLES
    track.forget_before(4 * MAX_SAMPLES * 50 + 10 * KEPT_US)
    assert len(track._stamps) == 1


def test_the_wait_is_what_a_live_firing_waits() -> None:
    assert started(wait_s=0.25).patience_s() == 0.25
    assert started().patience_s() == 0.1


def test_it_keeps_the_contract_of_stages() -> None:
    given = Since(samples(drive(0.3, 0.5), REGULAR))
    check_stage(Motion, {"flow": flow(), "odometry": given, "utime": Stamp(START_US + 200_000)})


FINITE = st.floats(-3.0, 3.0)


@given(FINITE, FINITE, FINITE, st.floats(0.0, 1.0))
def test_parts_of_an_arc_add_up_to_it(forward_m: float, left_m: float, turn_rad: float, share: float) -> None:
    end = arc(forward_m, left_m, turn_rad)
    before = part_of_arc(end, share)
    assert before == pytest.approx(arc(share * forward_m, share * left_m, share * turn_rad), abs=1e-9)
    assert before.then(part_of_arc(end.seen_from(before), 1.0)) == pytest.approx(end, abs=1e-9)
