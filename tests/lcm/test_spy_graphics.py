"""Pictures of the spy in a terminal that says what it can show: they come, and they go."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import sysconfig
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as PilImage

from graphnav.core.cli import main

from .spy_app import write_log

GRAPHNAV = str(Path(sysconfig.get_path("scripts")) / "graphnav")
PATIENCE_S = 60.0
ROWS, COLS = 40, 120
ATTRIBUTES, SIXEL_ATTRIBUTES = b"\x1b[?62;22c", b"\x1b[?62;4;22c"
KITTY_OK = b"\x1b_Gi=31;OK\x1b\\"
PUT = re.compile(rb"\x1b_Ga=T[^;]*?,i=(\d+),p=1,c=(\d+),r=(\d+)")
DELETED = re.compile(rb"\x1b_Ga=d,d=I,q=2,i=(\d+)\x1b")
SIXELS = re.compile(rb'\x1bP0;1;0q"1;1;(\d+);(\d+)')
BLOCK = "▀".encode()
LEFT = b"\x1b[?1049l"
OPEN_IMAGE = b"\x1b[F\x1b[A\r"
"""To the end of the table, up to the image, open."""
ESCAPE = b"\x1b[27u"
CHANNELS, CHANNEL = b"filter", b"expand"
"""Words that occur only in the footers of the screens."""


class Terminal:
    """The spy in a terminal that answers as asked for; ``shown`` is all that it was sent."""

    def __init__(self, log: Path, *words: str, attributes: bytes, kitty: bytes, **environment: str) -> None:
        self.shown = b""
        self._answers = {b"\x1b_Gi=31": kitty, b"\x1b[c": attributes}
        self._ours, theirs = pty.openpty()
        self.resize(ROWS, COLS)
        env = {name: value for name, value in os.environ.items() if name not in {"TMUX", "STY", "COLUMNS", "LINES"}}
        self._process = subprocess.Popen(
            ["setsid", "--ctty", GRAPHNAV, "spy", str(log), *words],
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            env={**env, "TERM": "xterm-256color", **environment},
            cwd=log.parent,
        )
        os.close(theirs)

    def resize(self, rows: int, cols: int) -> None:
        """Give the terminal a size, with cells of 20 x 10 pixels."""
        fcntl.ioctl(self._ours, termios.TIOCSWINSZ, struct.pack("HHHH", rows, cols, 20 * rows, 10 * cols))

    def until(self, condition: Callable[[bytes], object], since: int = 0) -> int:
        """Play the terminal until a condition holds for what was shown; return how much that is."""
        end_s = time.monotonic() + PATIENCE_S
        while not condition(self.shown[since:]):
            assert time.monotonic() < end_s, self.shown[-2000:]
            if select.select([self._ours], [], [], 0.1)[0]:
                self._take(os.read(self._ours, 65536))
        return len(self.shown)

    def press(self, keys: bytes) -> int:
        """Press keys; return how much was shown before."""
        os.write(self._ours, keys)
        return len(self.shown)

    def close(self) -> None:
        """End the spy with its key, and see all that it sends until then."""
        os.write(self._ours, b"q")
        while True:
            try:
                data = os.read(self._ours, 65536)
            except OSError:
                break
            self._take(data)
        assert self._process.wait(PATIENCE_S) == 0
        os.close(self._ours)

    def kill(self) -> None:
        """End the spy where a test did not."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
            os.close(self._ours)

    def _take(self, data: bytes) -> None:
        self.shown += data
        for question, answer in self._answers.items():
            if question in data:
                os.write(self._ours, answer)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a log with images."""
    return write_log(tmp_path / "run.lcmlog")


Start = Callable[..., Terminal]


@pytest.fixture
def start(log: Path) -> Iterator[Start]:
    """Return a function that starts the spy and opens the image."""
    made: list[Terminal] = []

    def started(*words: str, attributes: bytes = ATTRIBUTES, kitty: bytes = b"", **environment: str) -> Terminal:
        terminal = Terminal(log, *words, attributes=attributes, kitty=kitty, **environment)
        made.append(terminal)
        terminal.until(lambda shown: b"robot.state" in shown)
        at = terminal.press(OPEN_IMAGE)
        terminal.until(lambda shown: CHANNEL in shown, at)
        return terminal

    yield started
    for terminal in made:
        terminal.kill()


def test_by_default_nothing_is_asked_and_pictures_are_half_blocks(start: Start) -> None:
    terminal = start(attributes=SIXEL_ATTRIBUTES, kitty=KITTY_OK)
    terminal.until(lambda shown: BLOCK in shown)
    terminal.close()
    assert b"\x1b[c" not in terminal.shown
    assert b"\x1b_G" not in terminal.shown
    assert b"\x1bP" not in terminal.shown


def test_kitty_shows_pictures_and_deletes_every_one(start: Start) -> None:
    terminal = start("--graphics", "auto", kitty=KITTY_OK)
    terminal.until(PUT.search)
    at = terminal.press(b",")
    terminal.until(PUT.search, at)
    newest = PUT.findall(terminal.shown)[-1][0]
    at = terminal.press(b"vv")
    terminal.until(lambda shown: newest in DELETED.findall(shown), at)
    at = terminal.press(b"v")
    terminal.until(PUT.search, at)
    at = len(terminal.shown)
    terminal.resize(30, 100)
    terminal.until(lambda shown: any(int(rows) < 27 for *_, rows in PUT.findall(shown)), at)
    newest = PUT.findall(terminal.shown)[-1][0]
    at = terminal.press(ESCAPE)
    terminal.until(lambda shown: newest in DELETED.findall(shown) and CHANNELS in shown, at)
    terminal.close()
    assert BLOCK not in terminal.shown
    left = is_put(terminal.shown)
    assert not left, f"{left} are still on the screen"


def is_put(shown: bytes) -> set[bytes]:
    """Return the images that are on the screen at the end of what was shown, or when it was left."""
    images: set[bytes] = set()
    for found in re.finditer(rb"\x1b_Ga=(T|d)[^;]*?,i=(\d+)", shown[: shown.rindex(LEFT)]):
        images = images | {found[2]} if found[1] == b"T" else images - {found[2]}
    return images


def test_a_picture_that_is_open_at_the_end_is_deleted(start: Start) -> None:
    terminal = start("--graphics", "kitty")
    terminal.until(PUT.search)
    terminal.close()
    assert not is_put(terminal.shown)


@pytest.mark.parametrize("graphics", ["sixel", "kitty"])
def test_the_saved_screen_has_the_picture(start: Start, tmp_path: Path, graphics: str) -> None:
    terminal = start("--graphics", graphics)
    terminal.until((SIXELS if graphics == "sixel" else PUT).search)
    at = terminal.press(b"w")
    terminal.until(lambda shown: b"saved" in shown, at)
    terminal.close()
    (path,) = tmp_path.glob("spy-robot.image-*.png")
    with PilImage.open(path) as image:
        pixels = np.asarray(image.convert("RGB"))[60:-20, 480:]  # right of the fields, where no letters are
    is_picture = (pixels == 190).all(axis=2)
    rows, cols = np.nonzero(is_picture)
    height, width = int(np.ptp(rows)) + 1, int(np.ptp(cols)) + 1
    assert is_picture[rows.min() : rows.max() + 1, cols.min() : cols.max() + 1].all()
    assert height / width == pytest.approx(12 / 16, abs=0.1)


def test_sixels_are_shown_where_they_are_confirmed(start: Start) -> None:
    terminal = start("--graphics", "auto", attributes=SIXEL_ATTRIBUTES)
    terminal.until(SIXELS.search)
    terminal.resize(30, 100)
    at = len(terminal.shown)
    terminal.until(SIXELS.search, at)
    at = terminal.press(ESCAPE)
    terminal.until(lambda shown: CHANNELS in shown, at)
    terminal.close()
    assert BLOCK not in terminal.shown
    for width, height in SIXELS.findall(terminal.shown):
        assert int(width) <= 10 * COLS
        assert int(height) <= 20 * ROWS


@pytest.mark.parametrize("environment", [{"TMUX": "/tmp/socket,1,0"}, {"NO_COLOR": "1"}])
def test_half_blocks_are_the_safe_choice(start: Start, environment: dict[str, str]) -> None:
    is_plain = "NO_COLOR" in environment
    terminal = start(
        "--graphics",
        "auto",
        attributes=SIXEL_ATTRIBUTES if environment else ATTRIBUTES,
        kitty=KITTY_OK if environment else b"",
        **environment,
    )
    terminal.until(lambda shown: (b"########" if is_plain else BLOCK) in shown)
    terminal.close()
    assert not PUT.search(terminal.shown)
    assert not SIXELS.search(terminal.shown)


def test_what_no_terminal_has_is_a_users_error(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["spy", str(log), "--graphics", "iterm"])
    assert "invalid choice: 'iterm'" in capsys.readouterr().err
