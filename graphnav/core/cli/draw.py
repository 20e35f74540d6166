"""``graphnav draw``: draw a graph."""

from __future__ import annotations

import sys
from pathlib import Path

from graphnav.core.api.parameters import Shared
from graphnav.core.cli.command_arguments import CommandArguments
from graphnav.core.cli.status import Exit
from graphnav.core.errors import UserError
from graphnav.core.parameters import Parameter, command


@command(
    *Shared.LOADED,
    Parameter(
        "format",
        "--format",
        choices=("text", "svg", "mermaid", "dot"),
        default="text",
        help="boxes in the terminal (default), or the input of another program",
    ),
    Parameter("file", "-o", type=Path, metavar="FILE", help="output file (default: the terminal)"),
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.api.draw import Drawing

    _, graph = args.load_graph(partial=True, makes_stages=False)
    drawing = Drawing(graph)
    if args.format == "text" and args.file is None:
        from graphnav.core.machine.console import Console

        Console(highlight=False, soft_wrap=True).print(drawing)
        return Exit.OK
    written: str = getattr(drawing, args.format)
    if args.file is None:
        sys.stdout.write(written)
        return Exit.OK
    try:
        args.file.write_text(written, encoding="utf-8")
    except OSError as error:
        raise UserError.of(f"cannot write {args.file}: {error.strerror}", "choose another file with -o") from error
    return Exit.OK
