"""``graphnav ps``: list the runs of this user that are running, and the processes of their stages."""

from __future__ import annotations

import json
import time

from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.parameters import command


@command(Options.JSON.but(help="print JSON, for programs"))
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav import shown_path
    from graphnav.core.errors import shown_name
    from graphnav.core.machine import Console
    from graphnav.core.runner import RunningRun
    from graphnav.core.tables import Column, Table, print_fitted
    from graphnav.processes.running_runs import processes_of

    runs = [(run, processes_of(run)) for run in RunningRun.all()]
    if args.json:
        print(json.dumps([
            {"run": run.run_id, "graph": run.graph, "pid": run.pid, "folder": str(run.folder), "live": run.is_live,
             "for_s": time.time() - run.started_s, "processes": [process._asdict() for process in processes]}
            for run, processes in runs
        ]))  # fmt: skip
        return Exit.OK
    if not runs:
        print("no run is running")
        return Exit.OK
    rows: list[list[object]] = []
    for run, processes in runs:
        mode = "live" if run.is_live else "lockstep"
        since = f"{time.time() - run.started_s:.0f}"
        rows.append([run.run_id, shown_name(run.graph), run.pid, mode, since, None, shown_path(run.folder)])
        rows += [[f"  {name}", None, pid, None, None, restarts, None] for name, pid, restarts in processes]
    right = {"pid", "for s", "restarts"}
    names = ("run", "graph", "pid", "mode", "for s", "restarts", "folder")
    columns = [Column(name, align="right" if name in right else "left") for name in names]
    print_fitted(Console(), Table(columns, rows))
    return Exit.OK
