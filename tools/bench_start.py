"""Benchmark ``graphnav --help`` against ``python -c pass``, taking turns."""

from __future__ import annotations

import subprocess
import sys
import sysconfig
from collections.abc import Callable
from pathlib import Path

from taking_turns import Turns, load_told, take_turns, timed

GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"
OURS, BARE = "graphnav --help", "python -c pass"


def measure(rounds: int = 15) -> Turns:
    """Return the wall times of both."""
    rivals = {OURS: _program(str(GRAPHNAV), "--help"), BARE: _program(sys.executable, "-c", "pass")}
    return take_turns(rivals, rounds)


def _program(*command: str) -> Callable[[], float]:
    """Return a rival that is a program, whose output is dropped; it costs its wall time, s."""
    return timed(lambda: subprocess.run(command, stdout=subprocess.DEVNULL, check=True))


def main(rounds: int = 15) -> None:
    """Print both and their ratio."""
    turns = measure(rounds)
    for name in (OURS, BARE):
        print(f"{name}: {1e3 * turns.median(name):.1f} ms")
    print(f"ratio {turns.ratio(OURS, BARE)}")


if __name__ == "__main__":
    with load_told():
        main(*map(int, sys.argv[1:]))
