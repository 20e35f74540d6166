"""``graphnav logs``: print what a run printed: a detached run all, others what stages of their processes printed."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING

from graphnav.core.cli import CommandArguments, Exit
from graphnav.core.machine import open_regular
from graphnav.core.parameters import command, flag
from graphnav.processes.commands.stop import RUN

if TYPE_CHECKING:
    from pathlib import Path

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
    while True:
        is_last = not args.follow or run is None or not run.is_running
        for path, before in output_files(folder).items():
            read[path] = _print_lines(path, read.get(path, 0), before, is_last=is_last)
        if is_last:
            return Exit.OK
        time.sleep(_PERIOD_S)


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
