"""The spy in a real terminal: tmux shows what a user sees, in two sizes, with and without colour."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import shlex
import shutil
import signal
import struct
import subprocess
import sysconfig
import termios
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from testbed.terminal import PATIENCE_S, Terminal

from .spy_app import publishing

GRAPHNAV = str(Path(sysconfig.get_path("scripts")) / "graphnav")
TYPED = shlex.quote(GRAPHNAV)
MODES = "#{alternate_on} #{mouse_any_flag}"
"""Whether a program has the screen and the mouse for itself."""

pytestmark = pytest.mark.skipif(shutil.which("tmux") is None, reason="tmux is not installed")


@pytest.fixture
def terminal(tmp_path: Path) -> Iterator[Callable[..., Terminal]]:
    """Return a function that runs a command in a terminal of a size."""
    made: list[Terminal] = []

    def start(command: str, size: tuple[int, int], **environment: str) -> Terminal:
        one = Terminal(tmp_path / f"tmux-{len(made)}")
        made.append(one)
        one.start(command, size, **environment)
        return one

    yield start
    for one in made:
        one.close()


def open_image(one: Terminal) -> None:
    """Filter for the image and open it, at a person's pace."""
    one.press("/")
    one.wait_for(lambda shown: "part of a channel" in shown and "⏎ open" not in shown)
    one.press("image")
    one.wait_for(lambda shown: "control.twist" not in shown and "  image  " in shown)
    one.press("Enter")
    one.wait_for(lambda shown: "⏎ open" in shown)
    one.press("Enter")


@pytest.mark.parametrize("size", [(80, 24), (200, 50)], ids=lambda size: f"{size[0]}x{size[1]}")
def test_a_live_group_is_seen_in_tmux(group: str, terminal: Callable[..., Terminal], size: tuple[int, int]) -> None:
    one = terminal(f"{TYPED} spy '{group}'; sleep 60", size)
    one.wait_for(lambda shown: "no publisher" in shown)
    with publishing(group, "robot.image", "control.twist"):
        shown = one.wait_for(lambda shown: "control.twist" in shown and "Hz" in shown)
        assert ("transport ms" in shown) is (size[0] == 200)
        assert "freeze" in shown.splitlines()[-1]
        open_image(one)
        shown = one.wait_for(lambda shown: "▀" in shown)
        assert len(shown.splitlines()) <= size[1]
        one.press("Escape")
        one.wait_for(lambda shown: "▀" not in shown)
        one.press("q")


@pytest.mark.parametrize("variable", ["NO_COLOR=1", "TERM=vt100"])
def test_without_colour_pictures_are_shades(group: str, terminal: Callable[..., Terminal], variable: str) -> None:
    one = terminal(f"{variable} {TYPED} spy '{group}'; sleep 60", (80, 24))
    with publishing(group, "robot.image"):
        one.wait_for(lambda shown: "Hz" in shown)
        open_image(one)
        shown = one.wait_for(lambda shown: any(letter * 16 in shown for letter in ".:-=+*#%@"))
        assert "▀" not in shown
        coloured = one.screen("-e")
        assert "38;2;" not in coloured
        assert "48;2;" not in coloured


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_leaves_the_terminal_as_it_was(
    group: str, terminal: Callable[..., Terminal], tmp_path: Path, number: signal.Signals
) -> None:
    script = f'echo $$ > {tmp_path}/pid; exec {TYPED} spy "{group}"'
    one = terminal(f"sh -c {shlex.quote(script)}; echo status $?; sleep 60", (80, 24))
    one.wait_for(lambda shown: "no publisher" in shown)
    assert one.tmux("display-message", "-p", MODES) == "1 1\n"
    os.kill(int((tmp_path / "pid").read_text()), number)
    one.wait_for(lambda shown: f"status {128 + number}" in shown)
    assert one.tmux("display-message", "-p", MODES) == "0 0\n"


@contextmanager
def spy_on_a_pty(group: str) -> Iterator[tuple[int, int, subprocess.Popen[bytes]]]:
    """Run the spy without SIGHUP on a terminal until it shows a channel; yield the terminal's two ends and the spy."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 50, 200, 0, 0))
    environment = os.environ | {"TERM": "xterm-256color"}
    command = ["sh", "-c", f"trap '' HUP; exec {TYPED} spy '{group}'"]
    streams: dict[str, Any] = {"stdin": theirs, "stdout": theirs, "stderr": theirs}
    with (
        publishing(group, "robot.image", "control.twist"),
        subprocess.Popen(command, env=environment, start_new_session=True, **streams) as spy,
    ):
        try:
            shown = b""
            while b"control.twist" not in shown:
                shown += os.read(ours, 65536)
            yield ours, theirs, spy
        finally:
            spy.kill()
            os.close(theirs)


def test_a_terminal_that_is_closed_leaves_no_spy_behind(group: str) -> None:
    with spy_on_a_pty(group) as (ours, _, spy):
        os.close(ours)
        spy.wait(PATIENCE_S)


def test_a_second_signal_ends_a_spy_whose_terminal_takes_nothing(group: str) -> None:
    with spy_on_a_pty(group) as (ours, theirs, spy):
        termios.tcflow(theirs, termios.TCOOFF)
        os.write(ours, b"sS" * 200)
        time.sleep(2)  # then the queue of pending writes is full
        for _ in range(2):
            spy.terminate()
            time.sleep(0.2)
        assert spy.wait(PATIENCE_S) == -signal.SIGTERM
        os.close(ours)


def test_a_dumb_terminal_gets_the_plain_list(group: str, terminal: Callable[..., Terminal]) -> None:
    one = terminal(f"TERM=dumb {TYPED} spy '{group}'; sleep 60", (100, 24))
    with publishing(group, "control.twist"):
        shown = one.wait_for(lambda shown: "graphnav_lcm.twist_t, " in shown)
        assert "freeze" not in shown


def test_output_that_is_read_by_a_program_stays_as_it_is(group: str) -> None:
    with publishing(group, "control.twist"):
        done = subprocess.run(
            [GRAPHNAV, "spy", "--json", "--for", "1", group], capture_output=True, text=True, check=True
        )
    assert json.loads(done.stdout)["channels"]["control.twist"]["messages"] > 0
