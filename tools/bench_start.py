"""Benchmark ``graphnav --help`` against ``python -c pass``, taking turns."""

from __future__ import annotations

import sys
import sysconfig
from pathlib import Path

from taking_turns import Turns, program, show, take_turns

GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"
OURS, BARE = "graphnav --help", "python -c pass"


def measure(rounds: int = 15) -> Turns:
    """Return the wall times of both."""
    rivals = {OURS: program([str(GRAPHNAV), "--help"]), BARE: program([sys.executable, "-c", "pass"])}
    return take_turns(rivals, rounds)


def main(rounds: int = 15) -> None:
    """Print both and their ratio."""
    turns = measure(rounds)
    show(f"{name}: {1e3 * turns.median(name):.1f} ms" for name in (OURS, BARE))
    show([f"ratio {turns.ratio(OURS, BARE)}"])


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
