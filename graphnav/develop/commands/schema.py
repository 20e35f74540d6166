"""``graphnav schema``: print the JSON Schema of a kind of file, for completion in editors."""

from __future__ import annotations

import json
from typing import Any

from graphnav import Place, UserError, did_you_mean
from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit
from graphnav.core.parameters import Parameter, command


@command(
    Parameter(
        "of",
        "--of",
        default="graph",
        metavar="FORMAT",
        help="graph (default), study, hosts, map, or another format that a plugin reads",
    ),
    Shared.PLUGINS,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav import FileFormat
    from graphnav.core.graph import graph_schema
    from graphnav.core.rooms import in_room
    from graphnav.core.spec import plugin_formats

    catalog = args.catalog()
    if args.of == "graph":
        schema = graph_schema(catalog)
    else:
        of_rooms: list[FileFormat[Any]] = [in_room("studies.ablation.study").STUDY, in_room("processes.hosts").HOSTS]
        formats = {**{one.name: one for one in of_rooms}, **plugin_formats(catalog)}
        if args.of not in formats:
            known = ("graph", *formats)
            hint = did_you_mean(args.of, known) or f"formats are {', '.join(known)}"
            raise UserError.of(f"there is no file format '{args.of}'", hint, Place("--of"))
        schema = formats[args.of].schema()
    print(json.dumps(schema, indent=2))
    return Exit.OK
