"""``graphnav teleop`` in a real terminal: keys in, messages out, and the terminal left as it was."""

from __future__ import annotations

import contextlib
import os
import pty
import signal
import subprocess
import sys
import sysconfig
import termios
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphnav.core.cli import main
from graphnav.core.codec import decode
from graphnav.core.messages import Stop, Twist

from .listening import Listener

GRAPHNAV = str(Path(sysconfig.get_path("scripts")) / "graphnav")
IN_ITS_OWN_SESSION = (
    "import fcntl, os, sys, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0); os.execv(sys.argv[1], sys.argv[1:])"
)


class Terminal:
    """A terminal in which teleop runs."""

    def __init__(self, group: str, *options: str) -> None:
        self.listener = Listener(group)
        self.fd, self._inside = pty.openpty()
        self.before = termios.tcgetattr(self._inside)
        command = [sys.executable, "-c", IN_ITS_OWN_SESSION, GRAPHNAV, "teleop", "--url", group, *options]
        self.process = subprocess.Popen(
            command,
            stdin=self._inside,
            stdout=self._inside,
            stderr=self._inside,
            start_new_session=True,
            env={**os.environ, "COLUMNS": "80"},
        )
        self._shown = b""
        os.set_blocking(self.fd, False)
        self.wait_until_shown(b"publishing nothing")

    def wait_until_shown(self, text: bytes) -> None:
        """Wait until something is on the screen."""
        self.listener.listen_until(lambda: text in self.shown())
        assert text in self.shown(), self._shown.decode()

    def shown(self) -> bytes:
        """Return all that was on the screen."""
        with contextlib.suppress(BlockingIOError, OSError):
            self._shown += os.read(self.fd, 65536)
        return self._shown

    def type(self, keys: bytes) -> None:
        """Press keys."""
        os.write(self.fd, keys)

    def twists(self) -> list[tuple[float, float]]:
        """Return the commands that were received."""
        found = [decode(Twist, data)[2] for channel, data in self.listener.received if channel == "TELEOP"]
        return [(round(twist.v_mps, 6), round(twist.omega_radps, 6)) for twist in found]

    def listen_until_silent(self) -> None:
        """Listen until nothing was received for half a second."""
        last: list[float] = [len(self.listener.received), time.monotonic()]

        def is_silent() -> bool:
            if last[0] != len(self.listener.received):
                last[:] = [len(self.listener.received), time.monotonic()]
            self.shown()
            return time.monotonic() - last[1] > 0.5

        self.listener.listen_until(is_silent)

    def end(self) -> int:
        """Wait for the end; return the exit status."""
        self.listener.listen_until(lambda: self.shown() is not None and self.process.poll() is not None)
        return self.process.wait(30)

    def attributes(self) -> list[object]:
        """Return how the terminal is set."""
        return termios.tcgetattr(self._inside)

    def close(self) -> None:
        """End what still runs."""
        self.process.kill()
        self.process.wait()
        self.listener.close()
        os.close(self.fd)
        os.close(self._inside)


@pytest.fixture
def terminal(group: str) -> Iterator[Terminal]:
    """Return a terminal in which teleop runs."""
    made = Terminal(group, "--speed", "0.5", "--turn", "1")
    yield made
    made.close()


def test_keys_drive_and_letting_go_ends_in_silence(terminal: Terminal) -> None:
    assert terminal.attributes() != terminal.before, "keys come one by one"
    terminal.type(b"w")
    terminal.listener.listen_until(lambda: (0.0, 0.0) in terminal.twists())
    terminal.listen_until_silent()
    found = terminal.twists()
    assert found == sorted(found, reverse=True), "forward first, then zero"
    assert set(found) == {(0.5, 0.0), (0.0, 0.0)}
    terminal.type(b"\x1b[D")
    terminal.listener.listen_until(lambda: (0.0, 1.0) in terminal.twists())
    terminal.type(b"l")
    terminal.listener.listen_until(lambda: (0.0, -1.0) in terminal.twists())
    terminal.type(b"q")
    assert terminal.end() == 0
    assert terminal.attributes() == terminal.before
    seqs = [decode(Twist, data)[1] for _, data in terminal.listener.received]
    assert seqs == list(range(len(seqs)))


def test_a_stop_is_published_and_taken_back(terminal: Terminal) -> None:
    terminal.type(b"x")
    terminal.wait_until_shown(b"stop published")
    terminal.type(b"r")
    terminal.wait_until_shown(b"armed again")
    terminal.listen_until_silent()
    stops = [decode(Stop, data) for channel, data in terminal.listener.received if channel == "STOP"]
    assert [(seq, stop.engaged) for _, seq, stop in stops] == [(0, True), (1, False)]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP], ids=str)
def test_however_it_ends_it_says_zero_and_leaves_the_terminal_as_it_was(terminal: Terminal, number: int) -> None:
    terminal.type(b"w")
    terminal.listener.listen_until(lambda: (0.5, 0.0) in terminal.twists())
    terminal.process.send_signal(number)
    assert terminal.end() == 130
    assert terminal.attributes() == terminal.before
    terminal.listen_until_silent()
    assert terminal.twists()[-1] == (0.0, 0.0)
    assert b"Traceback" not in terminal.shown()


def test_ctrl_c_typed_ends_it_and_ctrl_z_does_not_halt_it(terminal: Terminal) -> None:
    terminal.type(b"\x1a\x1c\x13")
    terminal.type(b"w")
    terminal.listener.listen_until(lambda: (0.5, 0.0) in terminal.twists())
    terminal.type(b"\x03")
    assert terminal.end() == 130
    assert terminal.attributes() == terminal.before


def test_what_is_said_fits_the_terminal_and_begins_with_the_stop(terminal: Terminal) -> None:
    terminal.type(b"xw")
    terminal.wait_until_shown(b"stop published; keys give 0.50 m/s, 1.00 rad/s; publishing +0.50")
    terminal.type(b"q")
    assert terminal.end() == 0
    lines = terminal.shown().partition(b"\r\x1b[K")[2].split(b"\r\x1b[K")
    assert max(len(line.rstrip()) for line in lines) == 79


def test_without_a_terminal_it_says_so() -> None:
    done = subprocess.run([GRAPHNAV, "teleop"], stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == (
        "teleop reads keys, and standard input is not a terminal\n"
        "  run it in a terminal; in scripts use 'graphnav pub'\n"
    )


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--speed", "fast"], "argument --speed: 'fast' is not a number above 0"),
        (["--turn", "-1"], "argument --turn: '-1' is not a number above 0"),
        (["--timeout", "0"], "argument --timeout: '0' is not a number of seconds above 0"),
        (["--channel", "graphnav.x"], "argument --channel: channel names that begin with 'graphnav.' are reserved"),
    ],
)
def test_an_argument_that_is_wrong_is_refused(capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["teleop", *words])
    assert said in capsys.readouterr().err


def test_a_url_that_leads_nowhere_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    outside, inside = pty.openpty()
    with os.fdopen(inside) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        assert main(["teleop", "--url", "memq://"]) == 2
    os.close(outside)
    assert capsys.readouterr().err.startswith("--url: 'memq://' is not a udpm:// URL\n")
