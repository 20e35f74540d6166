"""``graphnav schema``: print the JSON Schema of graphs, for completion in editors."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from graphnav.cli.status import OK


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "--plugin", dest="plugins", action="append", default=[], type=Path, metavar="FILE", help="a file with stages"
    )


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from graphnav.catalog import Catalog  # noqa: PLC0415
    from graphnav.graph import graph_schema  # noqa: PLC0415

    catalog = Catalog()
    for plugin in args.plugins:
        catalog.add_file(plugin)
    print(json.dumps(graph_schema(catalog), indent=2))
    return OK
