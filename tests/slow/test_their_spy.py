"""LCM's own spy shows our channels, on a virtual display: two screenshots to look at."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from testbed.drives import GRAPHNAV, drive
from testbed.processes import await_file, end, group_url

from graphnav.develop.java import find_jdk
from tests.targets import Targets

from .display import display

_NEEDS = ("Xvfb", "xdotool", "import")
_FIRST_ROW_PX = (60, 28)
"""Where lcm-spy's table has its first channel: a double click opens it."""
_SHOWN_S = 5.0
_PATIENCE_S = 60.0


def test_exchange_lcm_spy_shows_our_channels(
    targets: Targets, seeds: range, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Start ``graphnav lcm-spy`` while a log is played: how many types it finds, and two screenshots to look at."""
    missing = [program for program in _NEEDS if shutil.which(program) is None]
    if missing or find_jdk().missing:
        pytest.skip(find_jdk().missing or f"{missing[0]} is not installed")
    url, run, nothing = group_url(232), tmp_path / "run", subprocess.DEVNULL
    drive("corridor_ccw", seeds[0], ("run.record=all", "run.until_s=15"), run)
    shots = tmp_path_factory.mktemp("lcm-spy")
    table, fields = shots / "table.png", shots / "fields.png"
    command = [str(GRAPHNAV), "play", str(run), "--url", url, "--loop"]
    player = subprocess.Popen(command, stdin=nothing, stdout=nothing, stderr=nothing)
    try:
        with display() as screen, _spy(tmp_path / "lcm-spy.txt", screen, url) as found:
            time.sleep(_SHOWN_S)
            _screenshot(screen, table)
            x, y = map(str, _FIRST_ROW_PX)
            _x(screen, "xdotool", "mousemove", x, y, "click", "--repeat", "2", "--delay", "120", "1")
            time.sleep(_SHOWN_S)
            _screenshot(screen, fields)
    finally:
        end(player)
    n_definitions = len([*(Path(__file__).resolve().parents[2] / "lcmtypes").glob("*.lcm")])
    text = f"lcm-spy found {found} types, {n_definitions} ship; look at {table} and {fields}"
    targets.check(text, good=found >= n_definitions)


@contextmanager
def _spy(said: Path, screen: str, url: str) -> Iterator[int]:
    """Start lcm-spy, which is Java in a shell; give how many types it found."""
    with said.open("wb") as file:
        command = ["env", f"DISPLAY={screen}", str(GRAPHNAV), "lcm-spy", url]
        process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT, start_new_session=True)
    try:
        await_file(said)
        end_s = time.monotonic() + _PATIENCE_S
        while not (found := re.search(r"Found (\d+) LCM types", said.read_text())) and time.monotonic() < end_s:
            time.sleep(0.2)
        yield int(found[1]) if found else 0
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _screenshot(screen: str, target: Path) -> None:
    _x(screen, "import", "-window", "root", str(target))


def _x(screen: str, *command: str) -> None:
    subprocess.run(command, env={**os.environ, "DISPLAY": screen}, check=True, capture_output=True)
