"""``graphnav set``: set parameters of stages while their run goes on."""

from __future__ import annotations

from graphnav.core.cli import CommandArguments
from graphnav.core.parameters import Parameter, command

RUNNING = Parameter(
    "run", "--run", metavar="RUN", help="its id, as 'graphnav ps' shows it, or its folder (default: the only one)"
)


@command(
    Parameter(
        "changes",
        nargs="+",
        metavar="STAGE.PARAMETER=VALUE",
        help="what to set: plane.threshold_px=0.4; its stage is rebuilt, and starts as it did when the run began",
        offers="overrides",
    ),
    RUNNING,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.processes.change_run import change_run

    return change_run(args.run, overrides=args.changes, kind="setting")
