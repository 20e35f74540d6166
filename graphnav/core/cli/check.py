"""``graphnav check``: report all errors of graphs without running them."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from graphnav.core.api.parameters import Shared
from graphnav.core.cli.command_arguments import CommandArguments
from graphnav.core.cli.options import Options
from graphnav.core.cli.quantities import counted
from graphnav.core.cli.status import Exit
from graphnav.core.errors import Place, Problem, UserError
from graphnav.core.parameters import command, flag

if TYPE_CHECKING:
    from graphnav.core.graph import Channel, Graph, Node
    from graphnav.core.tables import Table


@command(
    Shared.GRAPH.but(nargs="+"),
    Shared.SET,
    Shared.PLUGINS,
    Shared.TRUST,
    Options.VERBOSE.but(help="print the swaps that its own files make, and the traceback of what a plugin raises"),
    flag(
        "resolved",
        "--resolved",
        "print the graph with everything it extends, every swap and every parameter; it loads from any folder, "
        "with --plugin where its plugins are in another one",
    ),
)
def main(args: CommandArguments) -> int:
    """Run the command: load each graph, construct its stages, and let each check its files and devices.

    The exit status is 1 where plugins are not trusted: the rest is checked without them.
    """
    if args.resolved and len(args.graph) > 1:
        raise UserError.of("--resolved prints one graph", "name one", Place("--resolved"))
    problems: dict[Problem, None] = {}
    status: int = Exit.OK
    for name in args.graph:
        try:
            _, graph = args.load_graph(name, partial=not args.resolved)
            graph.without_left_out().make_stages()
        except UserError as error:
            problems |= dict.fromkeys(error.problems)
        else:
            status = max(status, _print(graph, args))
    if problems:
        raise UserError(problems)
    return status


def _print(graph: Graph, args: CommandArguments) -> int:
    """Print what a graph is made of, without the table where several are checked; return the exit status."""
    if args.resolved:
        from graphnav.core.graph import resolved_yaml

        sys.stdout.write(resolved_yaml(graph, portable_paths=False))
        return Exit.OK
    from graphnav.core.machine.console import Console
    from graphnav.core.tables import folded

    console = Console(highlight=False, soft_wrap=True)
    for notice in args.notices_of(graph):
        console.print(notice, markup=False)
    if len(args.graph) == 1:
        console.print(folded(_table(graph)))
    if graph.is_live:
        console.print(f"it runs live: {_outside(graph)}", markup=False)
    parts = [
        counted(len(graph.inputs), "input") if graph.inputs else "",
        counted(len(graph.sources), "source"),
        counted(len(graph.order), "other stage"),
        counted(len(graph.channels), "channel"),
        counted(len(graph.outputs), "output") if graph.outputs else "",
    ]
    counts = ", ".join(filter(None, parts))
    if graph.left_out:
        unknown = ", ".join(node.name for node in graph.nodes if node.is_left_out)
        left_out = f" ({unknown})" if unknown else ""
        console.print(f"{graph.path.name} is fine, except what was left out{left_out}: {counts}", markup=False)
        return Exit.FAILED
    console.print(f"{graph.path.name} is fine: {counts}", markup=False)
    return Exit.OK


def _outside(graph: Graph) -> str:
    """Return the connections of a live graph to other programs."""
    heard = [given.name for given in graph.inputs.values() if given.log is None]
    logs = dict.fromkeys(given.log.name for given in graph.inputs.values() if given.log is not None)
    sent = [f"{output.name}{' (motor)' if output.motor else ''}" for output in graph.outputs.values()]
    devices = [node.name for node in graph.nodes if node.is_live_source]
    parts = (
        ("it takes what devices deliver to", devices),
        ("it listens to", heard),
        ("it plays", logs),
        ("it sends", sent),
    )
    return ", ".join(f"{verb} {', '.join(names)}" for verb, names in parts if names)


def _table(graph: Graph) -> Table:
    from graphnav.core.cli.type_names import short_type
    from graphnav.core.tables import Table

    rows = []
    for given in graph.inputs.values():
        kind, where = ("log", f"{given.log.name}: {given.name}") if given.log else ("input", given.name)
        rows.append((given.channel.stage, kind, f"{where}: {short_type(given.type_name)}", _message(given.channel)))
    for node in (*graph.sources, *graph.order):
        reads = [f"{i.channel.ref}{f' ({i.port.reading})' if i.port.reading else ''}" for i in node.inputs if i.channel]
        rows.append((node.name, node.use, "\n".join(reads), "\n".join(_writes(node))))
    for output in graph.outputs.values():
        kind = "motor output" if output.motor else "output"
        rows.append(("", kind, output.channel.ref, f"{output.name}: {short_type(output.type_name)}"))
    return Table.plain(("stage", "uses", "reads", "writes"), rows)


def _writes(node: Node) -> list[str]:
    return [_message(c) + (f" as {c.name}" if c.name != c.ref else "") for c in node.outputs.values()]


def _message(channel: Channel) -> str:
    return f"{channel.ref}: {channel.type_text}"
