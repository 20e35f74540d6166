"""``graphnav logs``: print what a run printed: a detached run all, others what stages of their processes printed."""

from __future__ import annotations

import os
import select
import time
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING

from graphnav.core.cli import CommandArguments, Exit
from graphnav.core.machine import open_regular
from graphnav.core.parameters import command, flag
from graphnav.processes.commands.stop import RUN

if TYPE_CHECKING:
    from pathlib import Path

    from graphnav.core.runner import RunningRun

_PERIOD_S = 0.2
_CHUNK_BYTES = 65_536


@command(
    RUN.but(help="its id, as 'graphnav ps' shows it, or a run folder (default: the only one that is running)"),
    flag("follow", "-f --follow", "go on until the run ends"),
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.processes.running_runs import folder_named, output_files

    folder, run = folder_named(args.run)
    read: dict[Path, int] = {}
    with ExitStack() as stack:
        process = None if run is None else _detached_process(run, stack)
        while True:
            is_last = not args.follow or run is None or _has_ended(run, process)
            for path, before in output_files(folder).items():
                read[path] = _print_lines(path, read.get(path, 0), before, is_last=is_last)
            if is_last:
                return Exit.OK
            time.sleep(_PERIOD_S)


def _detached_process(run: RunningRun, stack: ExitStack) -> int | None:
    """Return a descriptor of the process that makes a detached run, None if the run is another one, or ends now."""
    from graphnav.core.run_folder import RunFolder

    if (run.folder / RunFolder.PRINTED).exists() and run.is_running:
        with suppress(OSError):
            process = os.pidfd_open(run.pid)
            stack.callback(os.close, process)
            return process
    return None


def _has_ended(run: RunningRun, process: int | None) -> bool:
    """Return whether a run has printed all: a detached one prints its summary after it was listed last."""
    return not run.is_running and (process is None or bool(select.select([process], [], [], 0)[0]))


def _print_lines(path: Path, at: int, before: str, *, is_last: bool) -> int:
    """Print the lines of a file from a location on; return the location behind them."""
    with os.fdopen(open_regular(path), "rb") as file:
        file.seek(at)
        while line := file.readline(_CHUNK_BYTES):
            if not line.endswith(b"\n") and len(line) < _CHUNK_BYTES and not is_last:
                break  # the rest will follow
            at += len(line)
            print(before + line.decode("utf-8", "replace").rstrip("\n"), flush=True)
    return at
