"""Commands become lines of a serial line, and stops where there are none; the line is a pseudo-terminal here."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from graphnav import Odometry, Twist, UserError
from graphnav.core.bus import Bus
from graphnav.core.cli import main
from graphnav.core.codec import decode, encode
from graphnav.live.base_bridge import BaseBridge
from graphnav.live.base_lines import CommandLine, OdometryLines
from graphnav.live.serial_line import SerialLine

PATIENCE_S = 60.0
STOP = b"0.000,0.000\n"
PLAIN = "{v_mps:.3f},{omega_radps:.3f}"
ODOMETRY = "O {x_m} {y_m} {yaw_rad} {v_mps} {omega_radps}"


class Base:
    """The base's end of a serial line, and the name by which the other end is opened."""

    def __init__(self, link: Path) -> None:
        self.link = link
        self.read = b""
        self._fd = -1
        self.plug()

    def plug(self) -> None:
        self._fd, other = pty.openpty()
        tty.setraw(other)
        os.set_blocking(self._fd, False)
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(os.ttyname(other))
        os.close(other)

    def unplug(self) -> None:
        """Pull the cable."""
        if self._fd >= 0:
            os.close(self._fd)
        self._fd = -1

    def lines(self) -> list[bytes]:
        """Return the complete lines that have come since the line was plugged in."""
        with suppress(OSError):  # nothing, or the other end is closed
            self.read += os.read(self._fd, 65536)
        return self.read.split(b"\n")[:-1]

    def say(self, data: bytes) -> None:
        os.write(self._fd, data)


class Running:
    """A bridge in a thread, and a program that sends it commands."""

    def __init__(self, base: Base, url: str, **options: object) -> None:
        self.base, self.told = base, list[str]()
        self.bus = Bus(url)
        self._seq = 0
        self._ending = threading.Event()
        self._options = {"timeout_s": 0.5, "odometry": None} | options
        self._thread = threading.Thread(target=self._serve, args=(url,))
        self._thread.start()
        self.until(lambda: STOP.strip() in base.lines())

    def send(self, v_mps: float, omega_radps: float = 0.0) -> None:
        self._seq += 1
        data = encode(Twist(v_mps=v_mps, omega_radps=omega_radps), time.time_ns() // 1000, self._seq)
        self.bus.publish("BASE_CMD", data)

    def until(self, holds: Callable[[], bool], sends: float | None = None) -> None:
        """Wait until something holds, and send a speed meanwhile."""
        end_s = time.monotonic() + PATIENCE_S
        while not holds():
            assert time.monotonic() < end_s, f"it never came: {self.told}, {self.base.lines()[-5:]}"
            if sends is not None:
                self.send(sends)
            time.sleep(0.02)

    def end(self) -> None:
        self._ending.set()
        self._thread.join()
        self.bus.close()

    def _serve(self, url: str) -> None:
        bus = Bus(url)
        line = CommandLine(PLAIN, None, None)
        bridge = BaseBridge(bus, "BASE_CMD", str(self.base.link), 115200, line, show=self.told.append, **self._options)  # type: ignore[arg-type]
        while not self._ending.is_set():
            bridge.turn(0.02)
        bridge.close()
        bus.close()


@pytest.fixture
def base(tmp_path: Path) -> Iterator[Base]:
    one = Base(tmp_path / "ttyUSB0")
    yield one
    one.unplug()


@pytest.fixture
def running(base: Base, group: str) -> Iterator[Callable[..., Running]]:
    """Return a function that starts a bridge, when the base has its first stop."""
    made: list[Running] = []

    def start(**options: object) -> Running:
        made.append(Running(base, group, **options))
        return made[-1]

    yield start
    for one in made:
        one.end()


def test_commands_are_lines_and_silence_is_a_stop(base: Base, running: Callable[..., Running]) -> None:
    one = running()
    one.until(lambda: b"0.250,0.000" in base.lines(), sends=0.25)
    base.read = b""
    one.until(lambda: base.lines()[-2:] == [STOP.strip()] * 2)
    assert one.told == [
        f"open: {base.link} at 115200 baud; it gets stops until commands come",
        "driving: commands come",
        "silent: no command for 0.5 s; the base gets stops",
    ]


def test_what_is_not_a_twist_is_not_used(base: Base, running: Callable[..., Running]) -> None:
    one = running()
    one.bus.publish("BASE_CMD", b"garbage")
    one.send(float("nan"))
    one.until(lambda: any(told.startswith("not used: ") for told in one.told))
    one.until(lambda: b"0.500,0.000" in base.lines(), sends=0.5)
    assert not any(b"nan" in line for line in base.lines())
    assert sum(told.startswith("not used: ") for told in one.told) == 1


def test_a_cable_that_is_pulled_is_told_and_the_line_opened_again(base: Base, running: Callable[..., Running]) -> None:
    one = running()
    one.until(lambda: b"0.250,0.000" in base.lines(), sends=0.25)
    base.unplug()
    base.link.unlink()
    one.until(lambda: any(told.startswith(f"lost: {base.link}: ") for told in one.told), sends=0.25)
    base.read = b""
    base.plug()
    one.until(lambda: b"0.300,0.000" in base.lines(), sends=0.3)
    lost = [told for told in one.told if told.startswith("lost: ")]
    assert len(lost) <= 2  # it is gone, then there is no such file
    assert all(told.endswith("it is opened again as soon as that is possible") for told in lost)
    assert one.told.count(f"open: {base.link} at 115200 baud; it gets stops until commands come") == 2


def test_a_base_that_does_not_read_holds_nothing_up_and_gets_the_newest(base: Base, group: str) -> None:
    bus, sender, told = Bus(group), Bus(group), list[str]()
    bridge = BaseBridge(
        bus,
        "BASE_CMD",
        str(base.link),
        115200,
        CommandLine("{v_mps:.3f}" + 3000 * " ", None, None),
        9.0,
        None,
        told.append,
    )
    try:
        bridge.turn(0.0)
        begin_s = time.monotonic()
        for k in range(100):  # more than the line holds
            sender.publish("BASE_CMD", encode(Twist(v_mps=float(k), omega_radps=0.0), k, k))
            bridge.turn(0.2)
        assert time.monotonic() - begin_s < 15
        for _ in range(2000):
            base.lines()
            bridge.turn(0.0)
            if base.lines()[-1:] and base.lines()[-1].startswith(b"99.000 "):
                break
        numbers = [float(line.split()[0]) for line in base.lines() if line.strip()]
        assert numbers[-1] == 99.0
        assert numbers == sorted(numbers)
        assert len(numbers) < 100
    finally:
        bridge.close()
        bus.close()
        sender.close()


def test_after_a_suspension_what_came_meanwhile_is_not_obeyed(base: Base, group: str) -> None:
    bus, sender, told = Bus(group), Bus(group), list[str]()
    bridge = BaseBridge(bus, "BASE_CMD", str(base.link), 115200, CommandLine(PLAIN, None, None), 0.1, None, told.append)
    try:
        bridge.turn(0.0)
        sender.publish("BASE_CMD", encode(Twist(v_mps=0.5, omega_radps=0.0), 0, 0))
        time.sleep(0.3)
        for _ in range(5):
            bridge.turn(0.05)
        assert set(base.lines()) == {STOP.strip()}
    finally:
        bridge.close()
        bus.close()
        sender.close()


def test_odometry_of_the_base_is_published(base: Base, running: Callable[..., Running], group: str) -> None:
    heard: list[Odometry] = []
    bus = Bus(group)
    bus.subscribe("ODOMETRY", lambda _, data: heard.append(decode(Odometry, data)[2]))
    one = running(odometry=("ODOMETRY", OdometryLines(ODOMETRY)))
    base.say(b"hello\r\nO 1.5 -2 0.25 0.1 -.5\r\nO 1.6 ")

    def has_come() -> bool:
        bus.drain()
        return bool(heard)

    one.until(has_come)
    base.say(b"-2 0.25 1e-1 0\r\n")
    one.until(lambda: has_come() and len(heard) == 2)
    bus.close()
    first = heard[0]
    assert (first.x_m, first.y_m, first.yaw_rad, first.v_mps, first.omega_radps) == (1.5, -2.0, 0.25, 0.1, -0.5)
    assert heard[1].x_m == 1.6
    assert "not used: a line of the base that does not fit --odometry" in one.told


def test_wheels_are_those_of_a_differential_drive() -> None:
    line = CommandLine(r"M {left_mps:.2f} {right_mps:.2f} {left_radps:.1f} {right_radps:.1f}\r\n", 0.4, 0.05)
    assert line.of(Twist(v_mps=0.2, omega_radps=0.5)) == b"M 0.10 0.30 2.0 6.0\r\n"
    assert line.stop == b"M 0.00 0.00 0.0 0.0\r\n"
    assert CommandLine("{v_mps}", None, None).of(Twist(v_mps=-0.0, omega_radps=0.0)) == b"0.0\n"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--format", "{speed}"], "--format has no field 'speed'\n  fields are v_mps, omega_radps, left_mps"),
        (["--format", "{v_mps.real}"], "--format has no field 'v_mps.real'\n"),
        (["--format", "{v_mps"], "--format: expected '}' before end of string\n"),
        (["--format", "go"], "--format has no field\n"),
        (["--format", "{v_mps:d}"], "--format: Unknown format code 'd' for object of type 'float'\n"),
        (["--format", "{left_mps}"], "--format has speeds of wheels, but the distance of the wheels is not known\n"),
        (["--format", "{left_radps}", "--track-m", "0.3"], "--format has turning rates of wheels, but their radius"),
        (["--odometry", "{x_m} {y_m}"], "--odometry lacks yaw_rad, v_mps, omega_radps\n"),
        (["--baud", "115000"], "--baud: a serial line cannot run at 115000 baud\n  did you mean 115200?"),
    ],
)
def test_what_cannot_be_written_is_refused(
    words: list[str], told: str, capsys: pytest.CaptureFixture[str], base: Base
) -> None:
    assert main(["base", str(base.link), *words]) == 2
    assert told in capsys.readouterr().err


def test_what_is_not_a_serial_line_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="it is not a serial line"):
        SerialLine(str(tmp_path / "file"), 9600)
    with pytest.raises(UserError, match="has no field"):
        OdometryLines("")


@pytest.mark.long
def test_the_command_ends_with_stops(base: Base, group: str) -> None:
    words = [sys.executable, "-m", "graphnav", "base", str(base.link), "--url", group]
    bridge = subprocess.Popen(words, stdout=subprocess.DEVNULL)
    bus = Bus(group)
    try:
        end_s = time.monotonic() + PATIENCE_S
        while b"0.250,0.000" not in base.lines():
            assert time.monotonic() < end_s
            bus.publish("BASE_CMD", encode(Twist(v_mps=0.25, omega_radps=0.0), 0, 0))
            time.sleep(0.02)
        bridge.send_signal(signal.SIGTERM)
        bridge.wait(PATIENCE_S)
        assert base.lines()[-3:] == [STOP.strip()] * 3
    finally:
        bridge.kill()
        bridge.wait()
        bus.close()
