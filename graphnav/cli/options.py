"""Arguments that several commands share: which graph, with which swaps."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav.errors import UserError

if TYPE_CHECKING:
    from graphnav.catalog import Catalog
    from graphnav.graph import Graph


def add_graph_options(parser: argparse.ArgumentParser) -> None:
    """Declare GRAPH, ``--set`` and ``--plugin``."""
    parser.add_argument("graph", metavar="GRAPH", help="a YAML file, or the name of a graph that ships")
    parser.add_argument(
        "--set",
        dest="sets",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="swap a stage (plane=plane.affine), a parameter (plane.threshold=4) or a wire (plane.in.flow=flow.flow)",
    )
    parser.add_argument(
        "--plugin", dest="plugins", action="append", default=[], type=Path, metavar="FILE", help="a file with stages"
    )


def load(args: argparse.Namespace) -> tuple[Catalog, Graph]:
    """Return the catalog with the ``--plugin`` files and the checked graph with its swaps, seed and end.

    Raises
    ------
    UserError
        Everything that is wrong with the graph or the options.
    """
    from graphnav.catalog import Catalog  # noqa: PLC0415
    from graphnav.graph import load_graph  # noqa: PLC0415

    catalog = Catalog()
    for plugin in args.plugins:
        catalog.add_file(plugin)
    graph = load_graph(args.graph, catalog, sets=args.sets)
    run = graph.run
    if getattr(args, "seed", None) is not None:
        run = replace(run, seed=args.seed)
    if getattr(args, "until", None) is not None:
        if not args.until > 0:
            raise UserError.of(f"--until is {args.until:g}, but must be above 0", "give seconds of simulated time")
        run = replace(run, until_s=args.until)
    return catalog, replace(graph, run=run)
