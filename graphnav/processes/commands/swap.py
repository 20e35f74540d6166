"""``graphnav swap``: swap stages while their run goes on."""

from __future__ import annotations

from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments
from graphnav.core.parameters import Parameter, command
from graphnav.processes.commands.set import RUNNING


@command(
    Parameter(
        "swaps",
        nargs="+",
        metavar="STAGE=FAMILY.STAGE",
        help="what to swap: plane=plane.affine; it starts as a stage does when a run begins",
        offers="overrides",
    ),
    Shared.SET.but(
        help="a parameter (plane.rule=otsu) to take over with it, or a wire of the new stage (plane.in.flow=flow.flow)"
    ),
    RUNNING,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.processes.change_run import change_run

    return change_run(args.run, overrides=args.swaps, kind="stage", settings=args.set)
