"""``graphnav schema``: print the JSON Schema of graphs, for completion in editors."""

from __future__ import annotations

import argparse
import json

from graphnav.cli.options import add_plugin_option, catalog_of
from graphnav.cli.status import OK


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_plugin_option(parser)


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from graphnav.graph import graph_schema

    print(json.dumps(graph_schema(catalog_of(args)), indent=2))
    return OK
