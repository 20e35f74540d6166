"""Benchmark ``graphnav --help`` against ``python -c pass``, alternating."""

from __future__ import annotations

import statistics
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"


def measure(rounds: int = 15) -> dict[str, float]:
    """Return medians of wall time in ms, and the median of the rounds' ratios."""
    pairs = [(_wall_s([str(GRAPHNAV), "--help"]), _wall_s([sys.executable, "-c", "pass"])) for _ in range(rounds + 1)]
    ours, bare = zip(*pairs[1:], strict=True)
    return {
        "graphnav --help, ms": statistics.median(ours) * 1e3,
        "python -c pass, ms": statistics.median(bare) * 1e3,
        "ratio": statistics.median(a / b for a, b in zip(ours, bare, strict=True)),
    }


def _wall_s(command: list[str]) -> float:
    begin = time.perf_counter()
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
    return time.perf_counter() - begin


if __name__ == "__main__":
    print({figure: round(value, 2) for figure, value in measure().items()})
