"""Starts ``graphnav`` commands, one per line of JSON on its standard input, by forks of one process.

A line ``{"words": ["run", ...], "output": FILE, "environment": {...}}`` is answered with the process's id. Starting
Python and importing scikit-learn takes seconds; a fork takes milliseconds, and is the same ``graphnav run``.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import sys
from typing import Any, NoReturn

from graphnav.core.machine.threads import ONE_THREAD

MODULES = (
    "graphnav_flow.lucas_kanade",
    "graphnav_odometry.motion",
    "graphnav_planar.motion",
    "graphnav_plane.ica",
    "graphnav_steer.pca",
    "graphnav_control.guard",
    "graphnav.core.cli.run",
    "graphnav.live",
    "graphnav.core.report.pictures",
    "graphnav.core.report.summary_text",
    "rich.console",
    "lcm",
)


def main() -> None:
    """Start what is asked for until standard input closes."""
    os.environ.update(ONE_THREAD)
    for module in MODULES:
        importlib.import_module(module)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # the kernel collects the children
    for line in sys.stdin:
        asked = json.loads(line)
        pid = os.fork()
        if pid == 0:
            _run(asked)
        print(pid, flush=True)


def _run(asked: dict[str, Any]) -> NoReturn:
    """Be the command."""
    from graphnav.core.cli import main as graphnav

    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    nothing = os.open(os.devnull, os.O_RDONLY)
    output = os.open(asked["output"], os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
    for descriptor, place in ((nothing, 0), (output, 1), (output, 2)):
        os.dup2(descriptor, place)
    os.environ.update(asked["environment"])
    try:
        status = graphnav(asked["words"])
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(status)


if __name__ == "__main__":
    main()
