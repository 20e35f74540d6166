"""The statistics of channels are correct, and bounded for any messages."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest

from graphnav.core.codec import codec_of, encode
from graphnav.core.messages import About, Image, Map, State, Status, Twist
from graphnav.core.typeinfo import load_types
from graphnav.watch.feed import MAX_CHANNELS, Received
from graphnav.watch.view.content.state import floor_map
from graphnav.watch.view.page_feed import PageState

TWIST = Twist(0.1, 0.2)


class Ear:
    """The state of a page on a clock that the test moves."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.state = PageState(lambda: self.now_s)
        self.watch = self.state.watch

    def receive(self, channel: str, data: bytes, after_s: float = 0.0) -> None:
        self.now_s += after_s
        self.state.receive(Received(channel, data, self.now_s))


@pytest.fixture
def ear() -> Ear:
    return Ear()


def test_rate_losses_and_silence(ear: Ear) -> None:
    for k in range(50):
        if k % 10 != 5:
            ear.receive("control.twist", encode(TWIST, k * 50_000, k), 0.05)
        else:
            ear.now_s += 0.05
    channel = ear.watch.channels["control.twist"]
    assert channel.rate_hz == pytest.approx(20)
    assert (channel.count, channel.lost, channel.undecodable) == (45, 5, 0)
    ear.now_s += 1.2
    assert channel.is_silent
    assert channel.rate_hz is None, "a silent channel has no rate"
    ear.receive("control.twist", encode(TWIST, 0, 0), 0.05)
    assert channel.lost == 5, "a publisher that restarts its numbers loses nothing by that"
    assert channel.lost_since_restart == 0


def test_pipeline_delay_is_counted_from_the_first_message_of_the_stamp(ear: Ear) -> None:
    for k in range(5):
        ear.receive("robot.image", encode(Image(np.zeros((2, 2), np.uint8)), k * 100_000, k), 0.1)
        ear.receive("control.twist", encode(TWIST, k * 100_000, k), 0.03)
    assert ear.watch.channels["control.twist"].pipeline_delay_s == pytest.approx(0.03)
    assert ear.watch.channels["robot.image"].pipeline_delay_s is None


def test_a_repeated_message_is_neither_lost_nor_late(ear: Ear) -> None:
    for _ in range(5):
        ear.receive("control.twist", encode(TWIST, 0, 0), 1.0)
    channel = ear.watch.channels["control.twist"]
    assert (channel.lost, channel.pipeline_delay_s, channel.is_single) == (0, None, True)
    assert channel.rate_hz is None


def test_a_sender_that_does_not_number_has_a_rate(ear: Ear) -> None:
    for k in range(50):
        ear.receive("control.twist", encode(TWIST, k * 50_000, 0), 0.05)
    channel = ear.watch.channels["control.twist"]
    periods = channel.published
    assert periods is not None
    assert periods.rate_hz == pytest.approx(20)
    assert periods.mean_s == pytest.approx(0.05)
    assert (channel.lost, channel.is_single) == (0, False)


def test_types_of_other_packages_are_known(ear: Ear, tmp_path: Path) -> None:
    (tmp_path / "gauge_t.lcm").write_text("package view_test; struct gauge_t { int64_t utime; double level; }\n")
    gauge = load_types([str(tmp_path)])["view_test.gauge_t"]
    ear.receive("gauge", codec_of(gauge).encode({"utime": 1, "level": 0.5}), 0.1)
    channel = ear.watch.channels["gauge"]
    assert (channel.type_name, channel.undecodable, channel.pipeline_delay_s) == ("view_test.gauge_t", 0, None)


def test_garbage_is_counted_and_bounded(ear: Ear) -> None:
    good = encode(TWIST, 0, 0)
    rng = random.Random(7)
    for k in range(20_000):
        ear.receive(f"noise {k}", rng.randbytes(rng.randrange(60)), 0.0001)
        ear.receive("control.twist", good[: rng.randrange(len(good))], 0.0001)
        flipped = bytearray(good)
        flipped[rng.randrange(len(good))] ^= 1 << rng.randrange(8)
        ear.receive("flipped", bytes(flipped), 0.0001)
    watch = ear.watch
    assert len(watch.channels) <= MAX_CHANNELS
    assert sum(channel.count for channel in watch.channels.values()) + watch.overflow == watch.count == 60_000
    assert watch.undecodable > 40_000
    assert watch.channels["control.twist"].undecodable == 20_000


def test_announced_channels_find_room_among_noise(ear: Ear) -> None:
    for k in range(1000):
        ear.receive(f"noise {k}", b"x")
    ear.receive(About.CHANNEL, encode(About("stages: {}", "", "a", 7, ("late",), ("graphnav_lcm.twist_t",)), 0, 0))
    ear.receive("late", encode(TWIST, 0, 0))
    assert ear.watch.channels["late"].count == 1


def test_silent_channels_make_room(ear: Ear) -> None:
    for k in range(MAX_CHANNELS):
        ear.receive(f"noise {k}", b"x")
    ear.receive("new", b"x", after_s=61)
    assert "new" in ear.watch.channels
    assert (ear.watch.overflow, ear.watch.count) == (MAX_CHANNELS, MAX_CHANNELS + 1), "the forgotten are counted"


def test_runs_are_bounded(ear: Ear) -> None:
    for k in range(100):
        ear.receive(About.CHANNEL, encode(About("stages: {}", "", f"run {k}", 7, (), ()), 0, k), 0.01)
        status = Status(f"run {k}", "g", False, 0, 0, 0, 0, 0, 0, "", (), (), (), ())
        ear.receive("graphnav.status", encode(status, 0, k), 0.01)
    assert len(ear.watch.announcements.runs) == 32
    assert len(ear.state.health.runs) == 32


def test_the_newest_living_run_is_shown_unless_one_is_chosen(ear: Ear) -> None:
    def announce(run_id: str) -> None:
        ear.receive(About.CHANNEL, encode(About("stages: {}", "", run_id, 7, (), ()), 0, 0), 0.5)

    runs = ear.watch.announcements
    assert runs.shown(None, 0.0) is None
    for run_id in ("old", "new", "old", "new"):
        announce(run_id)
    assert runs.shown(None, ear.now_s) == "new"
    assert runs.shown("old", ear.now_s) == "old"
    for _ in range(10):
        announce("old")
    assert runs.shown("new", ear.now_s) == "old", "the chosen run has ended"
    assert runs.shown(None, ear.now_s + 100) == "old", "the last one stays"


def test_large_messages_are_bounded_together(ear: Ear) -> None:
    data = encode(Image(np.zeros((2890, 2890), np.uint8)), 0, 0)
    for k in range(20):
        ear.receive(f"large {k}", data)
    kept = [channel for channel in ear.watch.channels.values() if channel.newest is not None]
    assert len(kept) == 16
    assert all(channel.is_too_large for channel in ear.watch.channels.values() if channel not in kept)


def test_history_is_bounded(ear: Ear) -> None:
    for k in range(5000):
        ear.receive("control.twist", encode(TWIST, k * 1000, k), 0.001)
    history = ear.watch.channels["control.twist"].history
    assert len(history) == 600
    assert history[-1][0] == 5000


def state(x_m: float) -> State:
    return State(x_m, 0, 0, 0, 0, 1, contact=False, at_goal=False, moving=np.empty((0, 3)))


def test_the_path_is_thinned_and_restarts_with_a_new_run(ear: Ear) -> None:
    for k in range(10_000):
        ear.receive("robot.state", encode(state(0.01 * k), k * 1000, k), 0.001)
    track = ear.state.track_of(None)
    assert 1000 < len(track.points_m) <= 4000
    assert track.points_m[0] == (0, 0)
    assert track.points_m == sorted(track.points_m)
    assert track.pose is not None
    assert track.pose[0] == pytest.approx(99.99)
    generation = track.generation
    ear.receive("robot.state", encode(state(1.0), 0, 0), 0.001)
    assert track.points_m == [(1, 0)]
    assert track.generation > generation


def test_a_pose_that_is_not_finite_is_left_aside(ear: Ear) -> None:
    ear.receive("robot.state", encode(state(float("nan")), 0, 0))
    assert ear.state.track_of(None).pose is None


@pytest.mark.parametrize("is_disc", [True, False])
def test_the_map_tells_the_robot_s_body(is_disc: bool) -> None:
    hull = [[-0.25, -0.2], [0.25, -0.2], [0.25, 0.2], [-0.25, 0.2]]
    n_robots = 0 if is_disc else 1
    world = Map(
        kind=np.full(n_robots, Map.ROBOT, np.uint8),
        height_m=np.zeros(n_robots),
        vertices_m=np.array(hull * n_robots).reshape(-1, 2),
        body=np.zeros(4 * n_robots, np.int32),
        start=np.zeros(3),
        goal_m=np.zeros((0, 2)),
        robot_radius_m=0.32,
        shortest_m=0.0,
        footprint_m=np.zeros((0, 2)),
    )
    shown = floor_map(encode(world, 0, 0))
    assert shown == {"areas": [], "robot_radius_m": 0.32, "robot_outline": None if is_disc else hull}
