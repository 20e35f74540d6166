"""``graphnav types``: list or describe LCM types; print definitions; write Java for lcm-spy."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.parameters import OneOf, Parameter, command, flag

if TYPE_CHECKING:
    from graphnav.core.machine import Console
    from graphnav.core.tables import Table

_EXAMPLES = """\
examples:
  graphnav types Flow                fields, units, shapes
  graphnav types twist_t --lcm       the definition, for lcm-gen in any language
  graphnav types --java types        a jar that lets lcm-spy show every field
"""


@command(
    Parameter(
        "name",
        metavar="NAME",
        nargs="?",
        help="a type (Flow, flow_t, package.type_t of an installed package or of --types); default: all",
        offers="types",
    ),
    OneOf(
        (
            Options.JSON.but(help="print JSON instead of tables"),
            flag("lcm", "--lcm", "print the definition, and those of all nested types"),
            Parameter(
                "java", "--java", type=Path, metavar="DIR", help="write Java sources and a jar for lcm-spy into DIR"
            ),
        )
    ),
    *Options.TYPES,
    examples=_EXAMPLES,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.machine import Console
    from graphnav.core.tables import folded
    from graphnav.core.typeinfo import definition_files, describe_type

    known = args.known_types()
    found = {args.name: known.called(args.name)} if args.name else known.every()
    console = Console(highlight=False)
    if args.lcm:
        print("\n".join(definition_files(found.values()).values()), end="")
    elif args.java is not None:
        _write_java(list(found.values()), args.java)
    elif args.json:
        described = [describe_type(lcm_class) for lcm_class in found.values()]
        print(json.dumps(described[0] if args.name else described, indent=2))
    elif args.name:
        _print_one(console, describe_type(found[args.name]))
    else:
        console.print(folded(_all(found)))
        console.print("'graphnav types NAME' describes one.", markup=False)
    return Exit.OK


def _all(found: dict[str, type]) -> Table:
    from graphnav.core.tables import Table
    from graphnav.core.typeinfo import describe_type

    rows = []
    for name, lcm_class in found.items():
        described = describe_type(lcm_class)
        rows.append((described["message"] or "", name, described["doc"].partition("\n")[0]))
    return Table.plain(("message", "LCM type", "description"), rows)


def _print_one(console: Console, described: dict[str, Any]) -> None:
    from graphnav.core.tables import Table, folded

    title = f"{described['message']}, {described['type']}" if described["message"] else described["type"]
    console.print(f"{title}, fingerprint {described['fingerprint']}", style="bold", markup=False)
    if described["doc"]:
        console.print()
        console.print(described["doc"], markup=False)
    rows = []
    for field in described["fields"]:
        dims = "".join(f"[{dim}]" for dim in field["dims"])
        kind = field["type"].removeprefix(f"{described['type'].rpartition('.')[0]}.")
        rows.append((field["name"], kind + dims, field["unit"], field["doc"]))
    console.print()
    console.print(folded(Table.plain(("field", "type", "unit", "description"), rows)))
    for name, value in described["constants"].items():
        console.print(f"{name} = {value}", markup=False)
    for name in described["nested"]:
        console.print(f"'graphnav types {name}' describes it.", markup=False)


def _write_java(lcm_classes: list[type], folder: Path) -> None:
    from graphnav.develop.java import write_java

    made = write_java(lcm_classes, folder)
    print(f"{len(made.sources)} sources below {folder}")
    if not made.is_built:
        print("javac is not installed: install a JDK, or run on a machine that has one")
        print("\n".join(f"  {command}" for command in made.commands))
    print(f"then CLASSPATH={made.jar.resolve()} lcm-spy shows these types")
