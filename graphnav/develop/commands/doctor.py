"""``graphnav doctor``: check this machine, and what a graph needs of it."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING

from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.parameters import Parameter, command

if TYPE_CHECKING:
    from collections.abc import Iterator

    from graphnav.develop.doctor import Finding


@command(
    Shared.GRAPH.but(nargs="?"),
    Shared.SET,
    Shared.PLUGINS,
    Shared.TRUST,
    Parameter(
        "host",
        "--host",
        metavar="NAME",
        help="check this host of the graph's 'deploy' in place of this machine, by ssh",
    ),
    Options.HOSTS,
    Options.JSON,
)
def main(args: CommandArguments) -> int:
    """Run the command; the exit status is 1 where something needed is lacking.

    A graph of which plugins are left out cannot run, so that the sizes of its messages are not measured.
    """
    findings = []
    for finding in _findings(args):
        findings.append(finding)
        if not args.json:
            _print(finding)
    if args.json:
        print(json.dumps([asdict(finding) for finding in findings], indent=2))
    return Exit.FAILED if any(finding.needed and not finding.fine for finding in findings) else Exit.OK


def _findings(args: CommandArguments) -> Iterator[Finding]:
    """Yield what is found on this machine, or on a host of the graph."""
    from graphnav import Place, UserError
    from graphnav.core.rooms import in_room
    from graphnav.develop.doctor import Finding, run_checks

    graph = None if args.graph is None else args.load_graph(partial=True)[1]
    if args.host is None:
        yield from run_checks(None if graph is None or graph.left_out else graph)
        return
    if graph is None:
        raise UserError.of("no graph is named", "write graphnav doctor GRAPH --host NAME", Place("--host"))
    declared = in_room("processes.hosts").declared_hosts(graph, args.hosts)
    if args.host not in declared:
        hint = f"its hosts are {', '.join(declared)}" if declared else "name one in its 'deploy'"
        raise UserError.of(f"no process of {graph.path.stem} lives on the host '{args.host}'", hint, Place("--host"))
    words = in_room("processes.started_hosts").words_for_hosts(args.graph, args.set, args.plugins)
    options = [Shared.TRUST.flag] if args.trust else []
    checks = in_room("processes.host_checks").host_checks
    for check in checks(graph, args.host, declared[args.host], words, options):
        yield Finding(**check._asdict())


def _print(finding: Finding) -> None:
    from rich.text import Text

    from graphnav.core.errors import printable
    from graphnav.core.machine import Console

    mark, style = ("ok ", "green") if finding.fine else ("FIX", "red") if finding.needed else ("opt", "yellow")
    console = Console(highlight=False, soft_wrap=True)
    console.print(Text.assemble((mark, style), f"  {finding.subject}: {printable(finding.seen)}"))
    if finding.fix:
        console.print(Text(f"     {printable(finding.fix)}"))
