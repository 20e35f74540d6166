"""Queries of terminal properties."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
import threading

import pytest

ASK = (
    "from graphnav.core.machine import terminal_graphics as asking; import os; asking._TIMEOUT_S = {patience_s}; "
    "os.write({fd}, repr(asking.TerminalGraphics.query()).encode())"
)
PATIENCE_S = 30.0
"""With a terminal that answers: the tests beside this one may take all processors for a while."""


class PlayedTerminal:
    """A terminal that answers what it is asked, and keeps the questions."""

    def __init__(self, answers: dict[bytes, bytes]) -> None:
        self.seen = b""
        self.answers = answers
        self.ours, self.theirs = pty.openpty()
        threading.Thread(target=self._play, daemon=True).start()

    def _play(self) -> None:
        while True:
            try:
                read = os.read(self.ours, 1024)
            except OSError:
                return
            self.seen += read
            for question, answer in self.answers.items():
                if question in read:
                    os.write(self.ours, answer)

    def close(self) -> None:
        """Close both ends."""
        os.close(self.theirs)
        os.close(self.ours)


def asked(terminal: PlayedTerminal, **environment: str) -> str:
    """Return what a program in the terminal finds out."""
    read_end, write_end = os.pipe()
    patience_s = PATIENCE_S if terminal.answers else 0.5
    env = {name: value for name, value in os.environ.items() if name not in {"TMUX", "STY"}}
    subprocess.run(
        ["setsid", "--ctty", sys.executable, "-c", ASK.format(fd=write_end, patience_s=patience_s)],
        stdin=terminal.theirs,
        stdout=terminal.theirs,
        env={**env, "TERM": "xterm-256color", **environment},
        pass_fds=[write_end],
        check=True,
        timeout=60,
    )
    os.close(write_end)
    said = os.read(read_end, 4096).decode()
    os.close(read_end)
    return said


ATTRIBUTES, KITTY, COLOURS, CELL = b"\x1b[c", b"\x1b_Gi=31", b"\x1b[?1;1;0S", b"\x1b[16t"


@pytest.mark.parametrize(
    ("answers", "said"),
    [
        (
            {COLOURS: b"\x1b[?1;0;1024S", CELL: b"\x1b[6;18;9t", ATTRIBUTES: b"\x1b[?62;4;22c"},
            "kitty=False, sixel=True, n_colours=1024, cell_px=(18, 9), failure=''",
        ),
        (
            {KITTY: b"\x1b_Gi=31;OK\x1b\\", ATTRIBUTES: b"\x1b[?62;c"},
            "kitty=True, sixel=False, n_colours=256, cell_px=None, failure=''",
        ),
        (
            {COLOURS: b"\x1b[?1;3;0S", CELL: b"\x1b[6;0;0t", ATTRIBUTES: b"\x1b[?63;1;2;4c"},
            "kitty=False, sixel=True, n_colours=256, cell_px=None, failure=''",
        ),
        ({COLOURS: b"\x1b[?1;0;0S", ATTRIBUTES: b"\x1b[?1;2c"}, "kitty=False, sixel=False, n_colours=2,"),
        ({}, "kitty=False, sixel=False"),
    ],
)
def test_a_terminal_says_what_it_can(answers: dict[bytes, bytes], said: str) -> None:
    terminal = PlayedTerminal(answers)
    assert said in asked(terminal)
    terminal.close()


@pytest.mark.parametrize("environment", [{"TMUX": "/tmp/socket,1,0"}, {"STY": "1.pts-0"}, {"TERM": "dumb"}])
def test_where_an_answer_means_nothing_nothing_is_asked(environment: dict[str, str]) -> None:
    terminal = PlayedTerminal({ATTRIBUTES: b"\x1b[?62;4c"})
    assert "kitty=False, sixel=False" in asked(terminal, **environment)
    assert not terminal.seen
    terminal.close()
