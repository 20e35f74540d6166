"""``graphnav draw``: draw a graph."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav.cli.options import add_graph_options, load
from graphnav.cli.status import OK
from graphnav.errors import UserError

if TYPE_CHECKING:
    from rich.console import Console

    from graphnav.render import TextDrawing

_COLOURS = ("cyan", "magenta", "green", "yellow", "blue", "red", "bright_cyan", "bright_magenta", "bright_green")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_graph_options(parser)
    parser.add_argument(
        "--format",
        choices=("text", "svg", "mermaid", "dot"),
        default="text",
        help="boxes in the terminal (default), or a text for other programs",
    )
    parser.add_argument("-o", dest="file", type=Path, metavar="FILE", help="where to write (default: the terminal)")


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from graphnav.render import dot_of, mermaid_of, svg_of, text_of  # noqa: PLC0415

    _, graph = load(args)
    if args.format == "text" and args.file is None:
        from rich.console import Console  # noqa: PLC0415

        _print(Console(highlight=False, soft_wrap=True), text_of(graph))
        return OK
    draw = {"text": lambda g: str(text_of(g)), "svg": svg_of, "mermaid": mermaid_of, "dot": dot_of}[args.format]
    if args.file is None:
        sys.stdout.write(draw(graph))
        return OK
    try:
        args.file.write_text(draw(graph), encoding="utf-8")
    except OSError as error:
        raise UserError.of(f"cannot write {args.file}: {error.strerror}", "choose another file with -o") from error
    return OK


def _print(console: Console, drawing: TextDrawing) -> None:
    """Print a drawing, every channel in a colour."""
    from rich.text import Text  # noqa: PLC0415

    for line, rails in zip(drawing.lines, drawing.rails, strict=True):
        text = Text(line)
        for at, rail in enumerate(rails[: len(line)]):
            if rail >= 0:
                text.stylize(_COLOURS[rail % len(_COLOURS)], at, at + 1)
        console.print(text)
