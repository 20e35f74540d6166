"""``graphnav restart``: restart a stage, as it is, while its run goes on."""

from __future__ import annotations

from graphnav.core.cli import CommandArguments
from graphnav.core.parameters import Parameter, command
from graphnav.processes.commands.set import RUNNING


@command(Parameter("stage", metavar="STAGE", help="its name in the graph"), RUNNING)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.processes.change_run import change_run

    return change_run(args.run, restart=args.stage)
