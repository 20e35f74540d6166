"""Channels pass a tunnel as both ends choose; nothing passes twice, and motors only by name."""

from __future__ import annotations

import argparse
import math
import re
import struct
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest
from testbed.slow_link import slow_link

from graphnav import Stop, Twist
from graphnav.core.bus import Bus
from graphnav.core.catalog import Catalog
from graphnav.core.codec import encode
from graphnav.core.graph import Graph, load_graph
from graphnav.core.runner import about_of
from graphnav.processes import host_clock, host_link
from graphnav.processes.frames import Frame
from graphnav.processes.host_link import HostCaller, HostListener, LinkError
from graphnav.processes.tunnel import tunnel as tunnel_module
from graphnav.processes.tunnel.choice import Choice, Chosen, chosen
from graphnav.processes.tunnel.end import Kind, TunnelEnd, Ways, is_name
from graphnav.processes.tunnel.motor_channels import MotorChannels
from graphnav.processes.tunnel.outbox import Passed
from graphnav.processes.tunnel.report import Report
from graphnav.processes.tunnel.tunnel import MAX_LINKS, SERVICE, Tunnel
from tests.lcm.listening import Listener

KEY = b"k" * 32
ALL = Choice([Chosen(".*")])
NONE = Choice([])
TWIST = encode(Twist(v_mps=0.1, omega_radps=0.0), 1, 1)
LARGE = bytes(922_000)
DOWN, UP = Ways(NONE, ALL), Ways(ALL, NONE)
"""As without options: the robot's end gives all and takes nothing, the laptop's the other way round."""


class Hosts:
    """Two groups, which stand in for two hosts, and tunnels between them, one step after another."""

    def __init__(self, robot: str, laptop: str) -> None:
        self.robot, self.laptop = robot, laptop
        self.tunnels: list[Tunnel] = []
        self.told: list[str] = []
        self._robots, self._laptops = Bus(robot), Bus(laptop)
        self.on_robot, self.on_laptop = Listener(robot), Listener(laptop)

    def serve(self, taken: Choice = NONE, given: Choice = ALL) -> Tunnel:
        """Serve the robot's group."""
        listener = HostListener("127.0.0.1", 0, KEY, SERVICE, MAX_LINKS)
        return self._tunnel(self.robot, Ways(taken, given), listener)

    def call(self, port: int, taken: Choice = ALL, given: Choice = NONE, url: str = "") -> Tunnel:
        """Call from the laptop's group."""
        caller = HostCaller("127.0.0.1", port, KEY, SERVICE)
        return self._tunnel(url or self.laptop, Ways(taken, given), caller)

    def join(self, robot: Ways = DOWN, laptop: Ways = UP) -> tuple[Tunnel, Tunnel]:
        """Serve and call; return both once they are connected."""
        serving = self.serve(*robot)
        calling = self.call(serving.links.port, *laptop)
        self.until_joined(serving, calling)
        return serving, calling

    def until_joined(self, *tunnels: Tunnel) -> None:
        """Wait until both ends know what the other one takes."""
        self.until(lambda: all(tunnel.ends and tunnel.ends[-1]._wanted for tunnel in tunnels))

    def from_robot(self, channel: str, data: bytes) -> None:
        """Send on the robot's group."""
        self._robots.send(channel, data)

    def from_laptop(self, channel: str, data: bytes) -> None:
        """Send on the laptop's group."""
        self._laptops.send(channel, data)

    def until(self, holds: Callable[[], object]) -> None:
        """Let all go on until something holds, half a minute at most."""
        end_s = time.monotonic() + 30
        while not holds():
            assert time.monotonic() < end_s
            self.step()

    def step(self) -> None:
        """Let all go on a little."""
        for tunnel in self.tunnels:
            tunnel.turn(0.002)
        for listener in (self.on_robot, self.on_laptop):
            listener.listen_until(lambda listener=listener: not listener._bus.handle(0.0))  # type: ignore[misc]

    def until_laptop_hears(self, channel: str) -> list[tuple[str, bytes]]:
        """Return what the laptop has heard once a message of a channel is among it."""
        self.until(lambda: channel in dict(self.on_laptop.received))
        return self.on_laptop.received

    def until_robot_hears(self, channel: str) -> list[tuple[str, bytes]]:
        """Return what the robot has heard once a message of a channel is among it."""
        self.until(lambda: channel in dict(self.on_robot.received))
        return self.on_robot.received

    def close(self) -> None:
        """Close everything."""
        for tunnel in self.tunnels:
            tunnel.close()
        for one in (self._robots, self._laptops, self.on_robot, self.on_laptop):
            one.close()

    def _tunnel(self, url: str, ways: Ways, links: HostListener | HostCaller) -> Tunnel:
        self.tunnels.append(Tunnel(url, ways, links, self.told.append, self.told.append))
        return self.tunnels[-1]


@pytest.fixture
def hosts(group: str, far_group: str) -> Iterator[Hosts]:
    """Return two hosts."""
    made = Hosts(group, far_group)
    yield made
    made.close()


def account(tunnel: Tunnel, way: int, channel: str) -> Passed:
    """Return the account of a channel: 0 came, 1 left, 2 as the other end tells."""
    return tunnel.accounts()[way].of(channel)


def test_the_laptop_hears_the_robot_and_not_the_other_way_round(hosts: Hosts) -> None:
    serving, calling = hosts.join()
    hosts.from_laptop("LAPTOP", b"stays")
    for k in range(20):
        hosts.from_robot("SMALL", bytes([k]))
    hosts.from_robot("LARGE", LARGE)
    hosts.from_robot("END", b"")
    heard = hosts.until_laptop_hears("END")
    hosts.until(lambda: "LARGE" in dict(heard))  # its packets leave one after another
    assert [data for channel, data in heard if channel == "SMALL"] == [bytes([k]) for k in range(20)]
    assert dict(heard)["LARGE"] == LARGE
    assert "LAPTOP" not in dict(hosts.on_robot.received)
    assert account(serving, 1, "SMALL").passed == account(calling, 0, "SMALL").passed == 20


def test_what_passes_is_chosen_by_both_ends(hosts: Hosts) -> None:
    robot = Ways(Choice([Chosen("UP.*")]), Choice([Chosen("DOWN|SEEN.*")]))
    hosts.join(robot, Ways(Choice([Chosen("SEEN|DOWN"), Chosen("OTHER")]), Choice([Chosen("UP"), Chosen("DOWN")])))
    for channel in ("SEEN", "SEEN.MORE", "OTHER", "DOWN"):
        hosts.from_robot(channel, b"r")
    for channel in ("UP", "UP.MORE", "SEEN"):
        hosts.from_laptop(channel, b"l")
    heard = hosts.until_laptop_hears("DOWN")
    assert {channel for channel, data in heard if data == b"r"} == {"SEEN", "DOWN"}
    heard = hosts.until_robot_hears("UP")
    assert {channel for channel, data in heard if data == b"l"} == {"UP"}


def test_nothing_passes_twice_whatever_joins_the_groups(hosts: Hosts) -> None:
    """Three tunnels between the same two groups, which carry everything both ways."""
    both = Ways(ALL, ALL)
    for _ in range(3):
        hosts.join(both, both)
    hosts.from_robot("ROBOT", b"r")
    hosts.from_laptop("LAPTOP", b"l")
    hosts.until(lambda: hosts.on_laptop.received.count(("ROBOT", b"r")) == 3)
    hosts.until(lambda: hosts.on_robot.received.count(("LAPTOP", b"l")) == 3)
    hosts.from_robot("END", b"")
    hosts.until_laptop_hears("END")
    hosts.from_laptop("END", b"l")
    hosts.until(lambda: ("END", b"l") in hosts.on_robot.received)
    for heard, once, thrice in (
        (hosts.on_robot.received, "ROBOT", "LAPTOP"),
        (hosts.on_laptop.received, "LAPTOP", "ROBOT"),
    ):
        channels = [channel for channel, _ in heard]
        assert (channels.count(once), channels.count(thrice)) == (1, 3)


def test_both_ends_in_one_group_are_an_error(hosts: Hosts) -> None:
    serving = hosts.serve()
    hosts.call(serving.links.port, url=hosts.robot)
    with pytest.raises(LinkError, match=r"both ends are in the group 239.255.77.\d+:\d+ of this machine"):
        hosts.until(lambda: False)


@pytest.fixture(scope="module")
def live_graph() -> Graph:
    """Return a graph with a motor output."""
    return load_graph("navigate_live", Catalog())


def test_motor_channels_pass_only_where_they_are_named(hosts: Hosts, live_graph: Graph) -> None:
    about = replace(about_of(live_graph, is_live=True), run_id="run")
    hosts.join(Ways(Choice([Chosen("TELEOP"), Chosen(".*")]), ALL), Ways(ALL, ALL))
    hosts.from_robot("graphnav.about", encode(about, 0, 0))
    hosts.until_laptop_hears("graphnav.about")
    for channel in ("BASE_CMD", "TELEOP", "UNKNOWN", "guard.twist"):
        hosts.from_robot(channel, TWIST)
    hosts.from_robot("STOP", encode(Stop(engaged=False), 1, 1))
    hosts.from_robot("BASE_CMD", b"of a type that is not known")
    hosts.from_robot("END", b"")
    heard = {channel for channel, _ in hosts.until_laptop_hears("END")}
    assert heard == {"graphnav.about", "guard.twist", "END"}  # tapped: it moves nothing
    for channel in ("BASE_CMD", "TELEOP", "STOP"):
        hosts.from_laptop(channel, TWIST + b"l")
    hosts.from_laptop("BASE_CMD", b"of another type l")
    hosts.from_laptop("END", b"l")
    hosts.until(lambda: ("END", b"l") in hosts.on_robot.received)
    assert {channel for channel, data in hosts.on_robot.received if data.endswith(b"l")} == {"TELEOP", "END"}
    serving, calling = hosts.tunnels
    assert account(serving, 1, "BASE_CMD").held == 2
    assert account(serving, 1, "STOP").held == 1
    assert account(calling, 1, "BASE_CMD").held == 1
    assert account(serving, 0, "BASE_CMD").held == 1  # the laptop does not know that the robot's run sends it to motors
    hosts.until(lambda: account(calling, 2, "BASE_CMD").held == 2)
    assert "7 on motor channels that are not named: BASE_CMD in 2" in Report(calling).losses()


@pytest.mark.parametrize("pattern", ["BASE_CMD", "guard\\.twist", "guard.twist"])
def test_a_pattern_that_is_a_name_names_it(pattern: str) -> None:
    name = pattern.replace("\\", "")
    assert Choice([Chosen("x"), Chosen(pattern)]).names(name)
    assert not Choice([Chosen(f"{pattern}|x")]).names(name)
    assert not Choice([Chosen(".*")]).names(name)


def test_announcements_that_are_none_teach_nothing(live_graph: Graph) -> None:
    motors = MotorChannels()
    good = encode(replace(about_of(live_graph, is_live=True), run_id="run"), 0, 0)
    for data in (b"", good[:60], b"x" * 100, encode(replace(about_of(live_graph), graph_yaml="[" * 3000), 0, 0)):
        motors._due_s = 0.0
        motors.learn(data)
        assert not motors.is_announced("BASE_CMD")
    motors._due_s = 0.0
    motors.learn(good)
    assert motors.is_announced("BASE_CMD")
    for k in range(40):
        motors._due_s = 0.0
        motors.learn(encode(replace(about_of(live_graph), graph_yaml="", run_id=str(k)), 0, 0))
    assert not motors.is_announced("BASE_CMD")  # forgotten: there are 32 newer runs
    assert len(motors._runs) == 32


def test_the_clock_of_the_other_end_is_told_and_what_follows(hosts: Hosts, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(host_link, "_ALIVE_S", 0.01)
    serving, calling = hosts.join()
    report, clock = Report(calling), calling.ends[0].link.clock
    hosts.until(lambda: clock.n_answers)
    assert report.clocks() == ""
    (line,) = report.clock_lines()
    assert re.fullmatch(r"clock of 127.0.0.1:\d+: [\d.]+ m?s (ahead|behind) ± .+|.+: alike within [\d.]+ m?s", line)
    serving.ends[0].link.wall_ns = lambda: time.time_ns() - 300_000_000
    hosts.until(lambda: clock.n_steps)
    assert re.fullmatch(
        r"the clock of (127.0.0.1:\d+) was set 0.\d\d s back; clock of \1: 0.\d\d s behind ± [\d.]+ m?s, set 1 time: "
        "what comes from there has its stamps, and live inputs count an offset below max_age_s as age: set the clocks "
        "of all machines alike, by chrony or PTP",
        report.clocks(),
    )
    n_answers = clock.n_answers
    hosts.until(lambda: clock.n_answers > n_answers)
    assert report.clocks() == ""
    told = report.clock_lines()
    calling._close(calling.ends[0])
    assert report.clock_lines() == told, "the last that was known"
    assert len(told) == 1


def test_a_clock_of_this_machine_that_is_set_is_told_as_such(hosts: Hosts, monkeypatch: pytest.MonkeyPatch) -> None:
    report = Report(hosts.serve())
    assert report.clocks() == ""
    monkeypatch.setattr(host_clock.read_clocks, "__defaults__", (lambda: time.time_ns() + 3_600_000_000_000,))
    assert report.clocks() == "the clock of this machine was set 3600 s ahead"
    assert report.clocks() == ""


def test_a_rate_thins_and_is_told_to_the_other_end(hosts: Hosts) -> None:
    _, calling = hosts.join(laptop=Ways(Choice([chosen("FAST@2"), Chosen(".*")]), NONE))
    for k in range(50):
        hosts.from_robot("FAST", bytes([k]))
    hosts.from_robot("END", b"")
    heard = hosts.until_laptop_hears("END")
    assert [data for channel, data in heard if channel == "FAST"] == [b"\0"]
    hosts.until(lambda: hosts.on_laptop.received[-1] == ("FAST", bytes([49])))  # half a second later
    hosts.until(lambda: account(calling, 2, "FAST").thinned == 48)
    assert Report(calling).losses() == "48 above their rate: FAST in 48"
    assert [row[:3] for row in Report(calling).table().rows] == [("END", "in", "1"), ("FAST", "in", "2")]
    assert Report(calling).sums() == "in 3 messages, 2 B; out 0 messages, 0 B"


def test_after_cuts_it_goes_on_in_order(hosts: Hosts) -> None:
    serving = hosts.serve()
    with slow_link(serving.links.port, 1e8) as link:
        calling = hosts.call(link.port)
        count = heard = 0

        def goes_on() -> bool:
            nonlocal count
            count += 1
            hosts.from_robot("COUNT", struct.pack(">Q", count))
            return len(hosts.on_laptop.received) > heard + 20

        for n_opened in (1, 2, 3):
            heard = len(hosts.on_laptop.received)
            hosts.until(goes_on)
            assert calling.n_opened == n_opened
            link.cut()
            hosts.until(lambda: not calling.ends)
        numbers = [struct.unpack(">Q", data)[0] for _, data in hosts.on_laptop.received]
        assert numbers == sorted(set(numbers))
        hosts.until(lambda: calling.n_opened == 4)
    again = [line for line in hosts.told if " again, after " in line]
    assert len(again) == 3


def test_a_slow_link_gets_the_newest_and_drops_are_counted_at_both_ends(hosts: Hosts) -> None:
    serving = hosts.serve()
    with slow_link(serving.links.port, 1e6) as link:
        calling = hosts.call(link.port)
        hosts.until_joined(serving, calling)
        begin_s, sent = time.monotonic(), 0
        while (now_s := time.monotonic() - begin_s) < 3.0:  # four times what the link carries
            if now_s > sent / 40:
                hosts.from_robot("IMAGE", struct.pack(">Q", sent) + bytes(100_000))
                sent += 1
            hosts.step()
        hosts.until(lambda: struct.pack(">Q", sent - 1) in {data[:8] for _, data in hosts.on_laptop.received})
        numbers = [struct.unpack(">Q", data[:8])[0] for channel, data in hosts.on_laptop.received if channel == "IMAGE"]
        assert numbers == sorted(set(numbers))
        left = account(serving, 1, "IMAGE")
        assert left.dropped > 0
        assert left.passed + left.dropped == sent
        hosts.until(lambda: account(calling, 2, "IMAGE").dropped == left.dropped)
        assert account(calling, 0, "IMAGE").passed + account(calling, 0, "IMAGE").dropped == left.passed
        assert "dropped: IMAGE in" in Report(calling).losses()
        assert "dropped: IMAGE out" in Report(serving).losses()


def test_a_group_that_is_heard_too_slowly_is_told(hosts: Hosts, monkeypatch: pytest.MonkeyPatch) -> None:
    serving, _ = hosts.join()
    monkeypatch.setattr(tunnel_module, "_MAX_WAITING", 50)
    monkeypatch.setattr(tunnel_module, "_AT_ONCE", 10)
    for k in range(100):
        hosts.from_robot("MANY", bytes([k]))
    hosts.until(lambda: account(serving, 1, "MANY").passed == 100)
    assert serving.n_overruns >= 1
    report = Report(serving)
    assert report.losses().startswith("this computer is too slow for all that is sent here")
    assert not report.losses()


HOSTILE = {
    "another kind": Frame(20, None),
    "a second choice": Frame(Kind.CHOICE, {"takes": [], "group": []}),
    "no channels": Frame(Kind.MESSAGES, None, (b"x",)),
    "fewer channels": Frame(Kind.MESSAGES, [], (b"x",)),
    "a number as channel": Frame(Kind.MESSAGES, [7], (b"x",)),
    "no numbers": Frame(Kind.LOST, {"A": [1, 2]}),
    "negative numbers": Frame(Kind.LOST, {"A": [1, 2, -3]}),
    "huge numbers": Frame(Kind.LOST, {"A": [1, 2, 1 << 70]}),
}


@pytest.mark.parametrize("frame", HOSTILE.values(), ids=HOSTILE)
def test_a_frame_that_is_none_of_a_tunnel_ends_it(frame: Frame, hosts: Hosts) -> None:
    serving, calling = hosts.join()
    calling.ends[0].link.send(frame)
    hosts.until(lambda: any(" sent " in line for line in hosts.told))
    hosts.until(lambda: calling.n_opened == serving.n_opened == 2)


@pytest.mark.parametrize(
    "takes",
    [None, 7, [["a"]], [[1, 2]], [["a", 0]], [["a", "b"]], [["(", None]], [["a" * 201, None]], [["a", None]] * 101],
)
def test_a_choice_that_is_none_is_refused(takes: object) -> None:
    with pytest.raises(ValueError, match=r"something else than|not above 0"):
        Choice.told(takes)


def test_a_choice_arrives_as_it_was_made() -> None:
    choice = Choice([chosen("robot.image@2.5"), chosen("a@b"), chosen("x.*")])
    for one in (choice, Choice.told([list(pair) for pair in choice.as_told])):
        limits = [one.limit_hz(name) for name in ("robot.image", "a@b", "xy", "y")]
        assert limits == [2.5, math.inf, math.inf, None]


@pytest.mark.parametrize("text", ["(", "a@0", "a@-1", "a@1e9", "a" * 201, "a{99999999999}"])
def test_a_pattern_that_is_none_is_an_error(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError):
        chosen(text)


def test_hostile_names_of_channels_are_refused_and_counted(hosts: Hosts) -> None:
    serving, calling = hosts.join()
    names = ["", "N" * 64, "A\0B", "\ud800", "é" * 32]
    serving.ends[0].link.send(Frame(Kind.MESSAGES, [*names, "A\x1b[31m", "END"], (b"x",) * 7))
    heard = hosts.until_laptop_hears("END")
    assert [channel for channel, _ in heard] == ["A\x1b[31m", "END"]
    assert [account(calling, 0, name).refused for name in names] == [1] * 5
    assert not any(map(is_name, names))


def test_what_an_end_has_not_chosen_does_not_reach_its_group(hosts: Hosts) -> None:
    """Whatever the other end sends."""
    serving, calling = hosts.join(laptop=Ways(Choice([Chosen("END")]), NONE))
    serving.ends[0].link.send(Frame(Kind.MESSAGES, ["OTHER", "END"], (b"x", b"y")))
    assert [channel for channel, _ in hosts.until_laptop_hears("END")] == ["END"]
    assert account(calling, 0, "OTHER").refused == 1
    assert isinstance(calling.ends[0], TunnelEnd)
