"""``graphnav doctor``: check this machine, and what a graph needs of it."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING

from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.parameters import command

if TYPE_CHECKING:
    from graphnav.develop.doctor import Finding


@command(Shared.GRAPH.but(nargs="?"), Shared.SET, Shared.PLUGINS, Shared.TRUST, Options.JSON)
def main(args: CommandArguments) -> int:
    """Run the command; the exit status is 1 where something needed is lacking.

    A graph of which plugins are left out cannot run, so that the sizes of its messages are not measured.
    """
    from graphnav.develop.doctor import run_checks

    graph = None if args.graph is None else args.load_graph(partial=True)[1]
    findings = []
    for finding in run_checks(None if graph is None or graph.left_out else graph):
        findings.append(finding)
        if not args.json:
            _print(finding)
    if args.json:
        print(json.dumps([asdict(finding) for finding in findings], indent=2))
    return Exit.FAILED if any(finding.needed and not finding.fine for finding in findings) else Exit.OK


def _print(finding: Finding) -> None:
    from rich.text import Text

    from graphnav.core.errors import printable
    from graphnav.core.machine import Console

    mark, style = ("ok ", "green") if finding.fine else ("FIX", "red") if finding.needed else ("opt", "yellow")
    console = Console(highlight=False, soft_wrap=True)
    console.print(Text.assemble((mark, style), f"  {finding.subject}: {printable(finding.seen)}"))
    if finding.fix:
        console.print(Text(f"     {printable(finding.fix)}"))
