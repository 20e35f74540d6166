"""``graphnav stop``: end a run that is running, as Ctrl-C does."""

from __future__ import annotations

import os
import signal
import sys
import time
from contextlib import suppress

from graphnav.core.cli import CommandArguments, Exit
from graphnav.core.parameters import Parameter, command, flag

RUN = Parameter(
    "run", metavar="RUN", nargs="?", help="its id, as 'graphnav ps' shows it, or its folder (default: the only one)"
)
_PATIENCE_S = 10.0
_PERIOD_S = 0.02


@command(
    RUN,
    flag("hard", "--hard", "kill it: its log has no end, and its processes are ended by their warden"),
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.processes.running_runs import run_named

    run = run_named(args.run)
    with suppress(ProcessLookupError):  # it has just ended
        os.kill(run.pid, signal.SIGKILL if args.hard else signal.SIGINT)
    end_s = time.monotonic() + _PATIENCE_S
    while run.is_running:
        if time.monotonic() > end_s:
            print(f"run {run.run_id} does not end\n  run graphnav stop --hard {run.run_id}", file=sys.stderr)
            return Exit.FAILED
        time.sleep(_PERIOD_S)
    print(f"run {run.run_id} has ended: {run.folder}")
    return Exit.OK
