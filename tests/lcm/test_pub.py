"""``graphnav pub``: what is written on the command line is received by other programs."""

from __future__ import annotations

import signal
import subprocess
import sysconfig
import time
from collections.abc import Iterator
from pathlib import Path

import graphnav_lcm
import pytest

from graphnav.core.bus import Bus
from graphnav.core.cli import main
from graphnav.core.codec import decode
from graphnav.core.messages import Stop, Twist
from graphnav.live.publish import Fields, Publisher, repeat

from .listening import Listener

GRAPHNAV = str(Path(sysconfig.get_path("scripts")) / "graphnav")


@pytest.fixture
def listener(group: str) -> Iterator[Listener]:
    """Return a listener on the test's group."""
    made = Listener(group)
    yield made
    made.close()


def test_one_message_is_sent_once(group: str, listener: Listener, capsys: pytest.CaptureFixture[str]) -> None:
    before_us = time.time_ns() // 1000
    assert main(["pub", "TELEOP", "Twist", "v_mps: 0.2, omega_radps: -1", "--url", group]) == 0
    ((channel, data),) = listener.wait_for(1)
    utime, seq, twist = decode(Twist, data)
    assert (channel, seq, twist.v_mps, twist.omega_radps) == ("TELEOP", 0, 0.2, -1.0)
    assert before_us <= utime <= time.time_ns() // 1000
    assert capsys.readouterr().out == (
        f"publishing graphnav_lcm.twist_t on 'TELEOP' once, {group}&recv_buf_size=2097152\n"
        "    v_mps        0.2\n    omega_radps  -1\n"
    )


def test_messages_at_a_rate_are_stamped_and_numbered(
    group: str, listener: Listener, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LCM_DEFAULT_URL", group)
    assert main(["pub", "STOP", "stop_t", "{engaged: true, reason: by hand}", "--rate", "200", "-n", "5"]) == 0
    found = [decode(Stop, data) for _, data in listener.wait_for(5)]
    assert [seq for _, seq, _ in found] == [0, 1, 2, 3, 4]
    stamps = [utime for utime, _, _ in found]
    assert stamps == sorted(set(stamps))
    assert {(stop.engaged, stop.reason) for _, _, stop in found} == {(True, "by hand")}
    assert capsys.readouterr().out.endswith("5 messages published\n")


def test_the_envelope_is_kept_where_it_is_given(group: str, listener: Listener) -> None:
    words = ["pub", "X", "graphnav_lcm.twist_t", "utime: 7, seq: 3", "--rate", "200", "-n", "2", "--url", group]
    assert main(words) == 0
    assert [decode(Twist, data)[:2] for _, data in listener.wait_for(2)] == [(7, 3)] * 2


def test_types_without_an_envelope_get_none() -> None:
    fields = Fields({"name": "plane.flow", "channel": "flow.flow", "overtaken": 2}, frozenset({"name", "channel"}))
    bus, received = Bus(), list[bytes]()
    bus.subscribe("x", lambda _, data: received.append(data))
    Publisher(bus, "x", graphnav_lcm.edge_status_t, fields).publish()
    bus.drain()
    bus.close()
    made = graphnav_lcm.edge_status_t()
    made.name, made.channel, made.overtaken = "plane.flow", "flow.flow", 2
    assert received == [made.encode()]


def test_ctrl_c_ends_it(group: str, listener: Listener) -> None:
    words = [GRAPHNAV, "pub", "X", "Twist", "--rate", "50", "--url", group]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert len(listener.wait_for(3)) >= 3
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert out.splitlines()[-1].endswith(" messages published")
    assert err == "stopped\n"


class Time:
    """A clock that advances only during sleeps."""

    def __init__(self) -> None:
        self.now_s = 100.0
        self.calls: list[float] = []
        self.takes_s = 0.0

    def publish(self) -> None:
        """Note when, and take a while."""
        self.calls.append(round(self.now_s - 100, 6))
        self.now_s += self.takes_s

    def sleep(self, seconds: float) -> None:
        """Pass."""
        self.now_s += seconds


def test_the_rate_is_kept() -> None:
    time_ = Time()
    time_.takes_s = 0.03
    repeat(time_.publish, 10, for_s=0.5, now_s=lambda: time_.now_s, sleep=time_.sleep)
    assert time_.calls == [0.0, 0.1, 0.2, 0.3, 0.4]


def test_what_is_late_is_not_made_up_for() -> None:
    time_ = Time()
    time_.takes_s = 0.25
    repeat(time_.publish, 10, n=3, now_s=lambda: time_.now_s, sleep=time_.sleep)
    assert time_.calls == [0.0, 0.25, 0.5]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["X", "Twst"], "there is no LCM type 'Twst'\n  did you mean 'Twist'?\n"),
        (
            ["X", "geometry.twist"],
            (
                "there is no LCM type 'geometry.twist'\n  'graphnav types' lists the shipped types; for others write "
                "package.type_t and install the package\n"
            ),
        ),
        (["X", "Twist", "v: 1"], "FIELDS:1:1: graphnav_lcm.twist_t has no field 'v'\n"),
        (["X", "Twist", "-n", "3"], "-n: without --rate only one message is published\n  give --rate HZ\n"),
        (["X", "Twist", "--for", "3"], "--for: without --rate only one message is published\n  give --rate HZ\n"),
        (
            ["X", "Twist", "--url", "memq://"],
            f"--url: 'memq://' is not a udpm:// URL\n  write {Bus.GROUP}, or another group of 239.0.0.0/8\n",
        ),
    ],
)
def test_a_command_line_that_is_wrong_is_refused(
    capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    assert main(["pub", *words]) == 2
    assert capsys.readouterr().err.startswith(said)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["a b", "Twist"],
            "argument CHANNEL: 'a b' cannot be a channel's name: use ASCII characters without spaces",
        ),
        (["", "Twist"], "argument CHANNEL: '' cannot be a channel's name: use ASCII characters without spaces"),
        (
            ["X" * 64, "Twist"],
            f"argument CHANNEL: the channel name '{'X' * 64}' has 64 characters, but LCM takes at most 63",
        ),
        (
            ["graphnav.status", "Twist"],
            "argument CHANNEL: channel names that begin with 'graphnav.' are reserved: 'graphnav.status'",
        ),
        (["X", "Twist", "--rate", "0"], "argument --rate: '0' is not a number above 0, from 1e-06 to 1e+06"),
        (["X", "Twist", "--rate", "nan"], "argument --rate: 'nan' is not a number above 0, from 1e-06 to 1e+06"),
    ],
)
def test_an_argument_that_is_wrong_is_refused(capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["pub", *words])
    assert capsys.readouterr().err.endswith(f"{said}\n")


def test_a_url_from_the_environment_is_named(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LCM_DEFAULT_URL", "tcpq://")
    assert main(["pub", "X", "Twist"]) == 2
    assert capsys.readouterr().err.startswith("LCM_DEFAULT_URL: 'tcpq://' is not a udpm:// URL\n")


@pytest.mark.parametrize("url", ["udpm://[", "udpm://127.0.0.1:7667", "udpm://239.255.77.1:99999", "udpm://x"])
def test_a_url_that_leads_nowhere_is_said(capsys: pytest.CaptureFixture[str], url: str) -> None:
    assert main(["pub", "X", "Twist", "--url", url]) == 2
    assert capsys.readouterr().err.startswith("--url: ")
