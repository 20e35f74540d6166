"""The command line of a machine whose time of day is an hour ahead, for live runs.

libfaketime lets sleeps of Python 3.11 fail with "Invalid argument", so that no run under it lasts.
"""

from __future__ import annotations

import functools
import sys
import time

from graphnav.core.cli import main
from graphnav.live import run
from graphnav.live.clock import LiveClock

AHEAD_US = 3_600_000_000

if __name__ == "__main__":
    vars(run)["LiveClock"] = functools.partial(LiveClock, wall_ns=lambda: time.time_ns() + AHEAD_US * 1000)
    sys.exit(main(sys.argv[1:]))
