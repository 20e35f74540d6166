"""``graphnav spy robot.local:`` and the other commands with a FEED show another computer, here on the loopback."""

from __future__ import annotations

import json
import math
import os
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from graphnav import About, Recording, Status, Twist
from graphnav.core.bus import Bus
from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.develop.completion.complete import other_computers
from graphnav.processes.frames import Frame, Link
from graphnav.processes.host_key import key_file, made_key
from graphnav.processes.host_link import VERSION, HostListener
from graphnav.processes.hosts import SERVICE as STAGES
from graphnav.processes.tunnel.choice import Choice, Chosen
from graphnav.processes.tunnel.end import Ways
from graphnav.processes.tunnel.far_group import FarGroup
from graphnav.processes.tunnel.tunnel import MAX_LINKS, SERVICE, Tunnel
from graphnav.watch.feed import Feed, LiveFeed, Received, host_of
from graphnav.watch.view import PageFeed
from tests.lcm.recording import wait_until
from tests.watch.view.served import Page, Served

HELLO = 240
"""The kind of the first frame of an end that listens."""
ABOUT = About("stages: {}\n", "", "run-a", 7, ("BASE_CMD",), ("graphnav_lcm.twist_t",))
STATUS = Status("run-a", "robot", True, 1.0, 1.0, 0.0, 1.0, 0, 0, "", (), (), (), ())


class Robot:
    """A group with a run that sends 50 times a second, and the end of a tunnel that serves it, in a thread."""

    def __init__(self, url: str, key: bytes, port: int = 0) -> None:
        everything, nothing = Choice([Chosen(".*")]), Choice([])
        listener = HostListener("127.0.0.1", port, key, SERVICE, MAX_LINKS)
        self.port = listener.port
        self.tunnel = Tunnel(url, Ways(nothing, everything), listener, lambda _: None, lambda _: None)
        self._bus = Bus(url)
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._go_on)
        self._thread.start()

    @property
    def feed(self) -> str:
        """As a user names it."""
        return f"localhost:{self.port}"

    def close(self) -> None:
        """Vanish, once."""
        if self._is_over.is_set():
            return
        self._is_over.set()
        self._thread.join()
        self.tunnel.close()
        self._bus.close()

    def _go_on(self) -> None:
        seq = 0
        while not self._is_over.is_set():
            seq += 1
            self._bus.send(About.CHANNEL, encode(ABOUT, seq, seq))
            self._bus.send("graphnav.status", encode(STATUS, seq, seq))
            self._bus.send("BASE_CMD", encode(Twist(v_mps=0.1, omega_radps=0.0), seq * 20_000, seq))
            self._bus.send("CAMERA", bytes(100_000))
            for _ in range(4):
                self.tunnel.turn(0.005)


@pytest.fixture
def key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> bytes:
    """Return the key of this user."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.chdir(tmp_path)
    return made_key(key_file(None))[0]


@pytest.fixture
def robot(key: bytes, far_group: str) -> Iterator[Robot]:
    """Return a robot, which is not in the group of this computer."""
    made = Robot(far_group, key)
    yield made
    made.close()


def test_spy_lists_its_channels_with_those_that_move_it_and_sends_nothing_there(
    robot: Robot, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["spy", robot.feed, "--json", "--for", "0.5"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["feed"] == robot.feed
    channels = {name: channel["messages"] for name, channel in told["channels"].items()}
    assert channels.keys() == {"BASE_CMD", "CAMERA", "graphnav.about", "graphnav.status"}
    assert all(channels.values())
    came, left, _ = robot.tunnel.accounts()
    assert came.channels == {}
    assert left.channels["BASE_CMD"].held == 0


def test_top_shows_its_run(robot: Robot, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["top", robot.feed, "--once", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["feed"], [run["run_id"] for run in told["runs"]]) == (robot.feed, ["run-a"])


@pytest.mark.parametrize("words", [["hz", "BASE_CMD"], ["hz"], ["bw", "BASE_CMD"]])
def test_rates_and_sizes_are_those_of_what_it_sends(
    words: list[str], robot: Robot, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words, robot.feed, "--json", "--for", "0.5"]) == 0
    channel = json.loads(capsys.readouterr().out)["channels"]["BASE_CMD"]
    assert channel["messages"] > 0
    assert channel["lost"] == 0


def test_echo_prints_messages(robot: Robot, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["echo", "BASE_CMD", robot.feed, "-n", "2", "--jsonl"]) == 0
    first, second = map(json.loads, capsys.readouterr().out.splitlines())
    assert second["fields"]["seq"] == first["fields"]["seq"] + 1


def test_a_channel_that_it_does_not_have_is_an_error(robot: Robot, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hz", "BASE_CMF", robot.feed]) == 2
    assert capsys.readouterr().err == f"{robot.feed} has no channel 'BASE_CMF'\n  did you mean 'BASE_CMD'?\n"


def test_record_writes_every_channel(robot: Robot, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["record", robot.feed, "-o", "a.lcmlog", "--for", "0.5"]) == 0
    assert f"\n  from {robot.feed}\n" in capsys.readouterr().out
    with Recording(tmp_path / "a.lcmlog") as recording:
        assert {event.channel for event in recording.events()} >= {"BASE_CMD", "CAMERA", "graphnav.about"}


def test_the_page_shows_it(robot: Robot) -> None:
    served = Served(PageFeed(Feed(robot.feed)))
    try:
        with Page(served) as page:
            page.until(lambda known: "BASE_CMD" in {one["name"] for one in known.get("state", {}).get("channels", ())})
    finally:
        served.close()


def test_after_a_cut_it_is_shown_again(robot: Robot, key: bytes, far_group: str) -> None:
    received: list[Received] = []
    feed = Feed(robot.feed)
    live = LiveFeed(feed, received.append)
    live.start()
    wait_until(lambda: bool(received))
    assert (live.failure, feed.connected_for_s > 0) == ("", True)
    robot.close()
    wait_until(lambda: live.failure.startswith(f"cannot connect to localhost, port {robot.port}: Connection refused\n"))
    assert feed.connected_for_s == 0
    received.clear()
    again = Robot(far_group, key, robot.port)
    wait_until(lambda: bool(received))
    assert live.failure == ""
    live.close()
    again.close()


@contextmanager
def listening(greet: Callable[[socket.socket], None]) -> Iterator[int]:
    """Take connections in a thread, and send each a greeting; yield the port."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        connections: list[socket.socket] = []

        def serve() -> None:
            with suppress(OSError):
                while True:
                    connections.append(server.accept()[0])
                    greet(connections[-1])

        thread = threading.Thread(target=serve)
        thread.start()
        yield int(server.getsockname()[1])
        server.shutdown(socket.SHUT_RDWR)
        thread.join()
    for connection in connections:
        connection.close()


def hello(version: int, service: str) -> Callable[[socket.socket], None]:
    """Return what sends the first frame of an end that listens."""

    def greet(connection: socket.socket) -> None:
        link = Link(connection.dup(), 512)
        link.send(Frame(HELLO, {"graphnav": version, "service": service, "nonce": "0" * 64}))
        link.close()

    return greet


NAME_PORT = "name the port of 'graphnav tunnel --serve' on localhost; this one is {port}"
REFUSALS = [
    (
        hello(99, SERVICE),
        f"has another version of this protocol than {VERSION}",
        "use the same version of graphnav on both hosts",
    ),
    (hello(VERSION, STAGES), f"serves another thing than a {SERVICE}", NAME_PORT),
    (lambda connection: connection.sendall(b"SSH-2.0-OpenSSH\r\n" * 9), "sent something else than frames", NAME_PORT),
]


@pytest.mark.parametrize(("greet", "what", "hint"), REFUSALS, ids=["version", "service", "ssh"])
def test_what_time_does_not_change_ends_a_command(
    greet: Callable[[socket.socket], None], what: str, hint: str, key: bytes, capsys: pytest.CaptureFixture[str]
) -> None:
    assert key
    with listening(greet) as port:
        for words in (["spy", "--once"], ["top"], ["hz"], ["echo", "x"], ["record"]):
            assert main([*words, f"localhost:{port}"]) == 2
            assert capsys.readouterr().err == f"127.0.0.1:{port} {what}\n  {hint.format(port=port)}\n"
    assert not list(Path().glob("*.lcmlog"))


def test_another_key_ends_a_command_and_is_shown_on_a_screen(robot: Robot, capsys: pytest.CaptureFixture[str]) -> None:
    path = key_file(None)
    path.write_text("ab" * 32)
    what = f"127.0.0.1:{robot.port} refused the connection: another key"
    told = f"{what}\n  copy the key of localhost to {path}, with mode 0600"
    assert main(["spy", robot.feed, "--once"]) == 2
    assert capsys.readouterr().err == f"{told}\n"
    live = LiveFeed(Feed(robot.feed), lambda _: None)
    live.start()
    wait_until(lambda: live.failure == told)
    live.close()


@pytest.mark.parametrize(
    ("words", "begin"),
    [
        (["spy", "--once", "--for", "0.1"], "no message on {feed} within 0.1 s: "),
        (["top", "--once", "--for", "0.1"], "no message on {feed} within 0.1 s: "),
        (["hz", "--for", "0.1"], "no message on {feed} within 0.1 s: "),
        (["echo", "x", "--timeout", "0.1"], "no message on {feed} within 0.1 s: "),
        (["record", "--for", "1", "-o", "a.lcmlog"], ""),
    ],
    ids=["spy", "top", "hz", "echo", "record"],
)
def test_a_computer_that_does_not_answer(
    words: list[str], begin: str, key: bytes, capsys: pytest.CaptureFixture[str]
) -> None:
    assert key
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    why = f"cannot connect to localhost, port {port}: Connection refused\n"
    hint = "  start 'graphnav tunnel --serve' on localhost, or name another address\n"
    assert main([*words, f"localhost:{port}"]) == 1
    assert capsys.readouterr().err == begin.format(feed=f"localhost:{port}") + why + hint


def test_a_name_that_is_none_is_told(key: bytes, capsys: pytest.CaptureFixture[str]) -> None:
    assert key
    name = "x" * 64
    assert main(["spy", f"{name}:", "--once", "--for", "0.1"]) == 1
    told = capsys.readouterr().err
    assert told.startswith(f"no message on {name}:7668 within 0.1 s: cannot connect to {name}, port 7668: ")
    assert told.count("\n") == 2


def test_without_a_key_it_says_where_to_copy_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    path = tmp_path / "graphnav" / "hosts.key"
    assert main(["spy", "robot.local:"]) == 2
    assert capsys.readouterr().err == (
        f"the key {path} does not exist\n  'graphnav tunnel --serve' or 'run --host' on the other host makes one: "
        f"copy it, with mode 0600, to {path}\n"
    )


def test_a_name_of_hosts_yaml_is_its_address(robot: Robot, capsys: pytest.CaptureFixture[str]) -> None:
    Path("hosts.yaml").write_text("hosts: {jetson: {address: 127.0.0.1}}")
    assert main(["echo", "BASE_CMD", f"jetson:{robot.port}", "-n", "1"]) == 0
    assert capsys.readouterr().out.startswith("BASE_CMD  graphnav_lcm.twist_t, 40 B\n")
    assert other_computers() == ["jetson:"]
    Path("hosts.yaml").write_text("hosts: {jetson: {}}")
    assert main(["spy", "robot.local:"]) == 2
    assert capsys.readouterr().err.startswith("hosts.yaml:1:")
    assert other_computers() == []


@pytest.mark.parametrize(
    ("name", "host"),
    [
        ("robot.local:", ("robot.local", None)),
        ("192.168.1.5:7668", ("192.168.1.5", 7668)),
        ("[fe80::1%eth0]:", ("fe80::1%eth0", None)),
        ("[::1]:17668", ("::1", 17668)),
        ("robot.local", None),
        ("camera:0", None),
        ("robot:99999", None),
        ("robot:1023", None),
        ("::1", None),
        ("me@robot.local:", None),
        ("runs/a:", None),
        ("udpm:", None),
        ("udpm://239.255.1.1:7667", None),
        (":", None),
        ("", None),
    ],
)
def test_what_is_another_computer(name: str, host: tuple[str, int | None] | None) -> None:
    assert host_of(name) == host


def test_a_file_that_exists_is_not_another_computer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("drive:").mkdir()
    Path("drive:1200").touch()
    assert host_of("drive:") is host_of("drive:1200") is None
    assert Feed("drive:1200").path == Path("drive:1200")


def test_what_is_needed_comes_completely_and_of_the_rest_a_little(key: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    assert key
    asked: list[Ways] = []

    def tunnel(url: str, ways: Ways, *_: object) -> Tunnel:
        asked.append(ways)
        raise InterruptedError(url)

    monkeypatch.setattr("graphnav.processes.tunnel.far_group.Tunnel", tunnel)
    for channels in (["a.b"], None):
        with pytest.raises(InterruptedError, match="memq://"):
            FarGroup("robot.local", None, channels).subscribe_all(print)
    some, everything = (ways.taken for ways in asked)
    assert [some.limit_hz(name) for name in ("a.b", "graphnav.about", "axb")] == [math.inf, math.inf, 2.0]
    assert everything.limit_hz("axb") == math.inf
    assert all(ways.given.limit_hz("a.b") is None for ways in asked)


def test_a_group_is_always_connected(group: str) -> None:
    feed = Feed(group)
    assert (feed.failure, feed.losses, feed.connected_for_s) == ("", "", math.inf)
    assert os.environ["LCM_DEFAULT_URL"] == group
