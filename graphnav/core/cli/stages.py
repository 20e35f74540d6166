"""``graphnav stages``: list the installed stages, or describe one."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from graphnav.core.api.parameters import Shared
from graphnav.core.cli.command_arguments import CommandArguments
from graphnav.core.cli.options import Options
from graphnav.core.cli.status import Exit
from graphnav.core.errors import shown_name
from graphnav.core.parameters import Parameter, command

if TYPE_CHECKING:
    from graphnav.core.catalog import Catalog
    from graphnav.core.machine.console import Console
    from graphnav.core.messages import Message
    from graphnav.core.tables import Table


_MIN_COLS_OF_PORTS = 110
"""A narrower terminal shows only what each stage is."""


@command(
    Parameter(
        "name",
        metavar="NAME",
        nargs="?",
        help="a stage (plane.ica), a family (plane), or a message (LocalMap): what writes and reads it; default: all",
        offers="stages",
    ),
    Options.JSON.but(help="print JSON instead of tables"),
    Shared.PLUGINS,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.machine.console import Console
    from graphnav.core.stage import describe
    from graphnav.core.tables import folded

    catalog = args.catalog()
    console = Console(highlight=False)
    if args.name and "." not in args.name and args.name not in catalog.families():
        _print_ports(args, console, catalog, _message_called(args.name, catalog))
        return Exit.OK
    if args.name and args.name not in catalog.families():
        described = describe(args.name, catalog.stage(args.name), catalog.origin(args.name))
        if args.json:
            print(json.dumps(described, indent=2))
        else:
            _print_one(console, described)
        return Exit.OK
    uses = _uses(catalog, [args.name] if args.name else list(catalog.families()), all_must_load=bool(args.name))
    if args.json:
        print(json.dumps([describe(use, catalog.stage(use), catalog.origin(use)) for use in uses], indent=2))
    else:
        console.print(folded(_all(catalog, uses, with_ports=console.width >= _MIN_COLS_OF_PORTS)))
        console.print("details: graphnav stages NAME", markup=False)
    return Exit.OK


def _message_called(name: str, catalog: Catalog) -> type[Message]:
    """Return the message class of a name, in any case, or of its LCM type's.

    Raises
    ------
    CatalogError
        There is none; the hint names the stages or messages that are near.
    """
    from graphnav.core.codec import message_classes
    from graphnav.core.errors import CatalogError, did_you_mean

    catalog.load_types()
    named: dict[str, type[Message]] = {}
    for message in reversed(list(message_classes())):
        named |= {message.lcm_class.__name__: message, message.__name__: message}
    lower = {key.lower(): key for key in (*catalog.families(), *named)}
    if (key := lower.get(name.lower())) in named:
        return named[key]
    try:
        catalog.stage(name)
    except CatalogError as error:
        near = [lower[word] for word in did_you_mean(name.lower(), lower).names]
        hint = f"did you mean '{near[0]}'?" if near else error.hint
        raise CatalogError(f"'{shown_name(name)}' is not a stage, a family or a message", hint) from error
    raise AssertionError("a stage has a family")


def _print_ports(args: CommandArguments, console: Console, catalog: Catalog, message: type[Message]) -> None:
    """Print the stages that write a message type, then those that read it."""
    from graphnav.core.stage import summary_of
    from graphnav.core.tables import Table, folded

    ports = sorted(catalog.ports(message), key=lambda found: not found[2])
    if args.json:
        sides = {True: "writers", False: "readers"}
        listed: dict[str, Any] = {"message": message.__name__, "writers": [], "readers": []}
        for use, port, is_output in ports:
            listed[sides[is_output]].append({"stage": use, "port": port.name, "reading": port.reading})
        print(json.dumps(listed, indent=2))
        return
    rows = []
    for use, port, is_output in ports:
        how = f"{port.name}{f' ({port.reading})' if port.reading else ''}"
        rows.append(("written by" if is_output else "read by", use, how, summary_of(catalog.stage(use))))
    table = folded(Table.plain((message.__name__, "stage", "port", "description"), rows))
    console.print(table if ports else f"no installed stage writes or reads {message.__name__}", markup=False)
    console.print(f"fields: graphnav types {message.__name__}", markup=False)


def _uses(catalog: Catalog, families: list[str], *, all_must_load: bool) -> list[str]:
    """Return the stages of families; an import error is reported, or raised if only one family is requested."""
    from graphnav.core.errors import CatalogError

    uses: list[str] = []
    for family in families:
        try:
            uses += [f"{family}.{name}" for name in catalog.names(family)]
        except CatalogError as error:
            if all_must_load:
                raise
            print(error, file=sys.stderr)
    return uses


def _all(catalog: Catalog, uses: list[str], *, with_ports: bool) -> Table:
    from graphnav.core.stage import ports_of, summary_of
    from graphnav.core.tables import Table

    rows = []
    for use in uses:
        cls = catalog.stage(use)
        ports = ports_of(cls)
        reads = ", ".join(f"{p.name}{f' ({p.reading})' if p.reading else ''}" for p in ports.inputs)
        writes = ", ".join(p.name for p in ports.outputs)
        if cls.ports_from:
            reads = writes = f"as {_and(cls.ports_from)} say"
        rows.append((use, *((reads, writes) if with_ports else ()), summary_of(cls)))
    return Table.plain(("stage", *(("reads", "writes") if with_ports else ()), "description"), rows)


def _print_one(console: Console, described: dict[str, Any]) -> None:
    from graphnav.core.tables import folded

    console.print(
        f"{described['name']}, a {described['kind']} of {described['origin']}",
        style="bold",
        markup=False,
        soft_wrap=True,
    )
    console.print()
    console.print(_flowing(described["doc"]), markup=False)
    if described["ports_from"]:
        console.print()
        console.print(f"Its ports are as {_and(described['ports_from'])} say.", markup=False)
    for table in _tables(described):
        if table.rows:
            console.print()
            console.print(folded(table))
    console.print()
    console.print("In a graph:")
    console.print(_snippet(described), markup=False, soft_wrap=True)


def _and(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _tables(described: dict[str, Any]) -> Iterator[Table]:
    """Yield the ports, the parameters and the metrics of a stage."""
    from graphnav.core.tables import Table

    ports = [(port["name"], port["type"], f"input, {_reading(port)}") for port in described["inputs"]]
    ports += [(port["name"], port["type"], "output") for port in described["outputs"]]
    yield Table.plain(("port", "type", ""), ports)
    params = []
    for param in described["parameters"]:
        kind = param["type"] + (f", {param['bounds']}" if param["bounds"] else "")
        kind += f", {param['unit']}" if param["unit"] else ""
        params.append((param["name"], kind, _default(param), param["doc"]))
    yield Table.plain(("parameter", "type", "default", "meaning"), params)
    metrics = [
        (one["name"], one["unit"], one["better"], _if_failed(one), _min_difference(one), one["doc"])
        for one in described["metrics"]
    ]
    yield Table.plain(("metric", "unit", "better", "if failed", "matters from", "what it means"), metrics)


def _reading(port: Mapping[str, Any]) -> str:
    """Return how an input is read."""
    if port["latest"]:
        return "sampled when another input fires the stage; may be unwired"
    if port["since"]:
        return "all messages since the last firing; may be unwired"
    return "fires the stage; may be unwired" if port["open"] else "fires the stage"


def _if_failed(metric: Mapping[str, Any]) -> str:
    """Return what a metric is of a drive that did not arrive; an outcome says whether it did."""
    value = metric["if_failed"]
    text = value if isinstance(value, str) else f"{value:g}"
    return f"{text} (outcome)" if metric["outcome"] else text


def _min_difference(metric: Mapping[str, Any]) -> str:
    """Return the smallest difference that matters; empty where any does, or neither direction is better."""
    return f"{metric['min_difference']:g}" if metric["min_difference"] else ""


def _flowing(doc: str) -> str:
    """Return a docstring with one line per paragraph, which the terminal wraps to its width."""
    lines: list[str] = []
    for line in doc.splitlines():
        last = lines[-1] if lines else ""
        begins = not (line and last) or line.startswith(("- ", ".. ")) or "---" in (line[:3], last[:3])
        if begins:
            lines.append(line)
        else:
            lines[-1] = f"{last} {line.strip()}"
    return "\n".join(lines)


def _default(param: dict[str, Any]) -> str:
    from graphnav.core.spec import write_value

    return "required" if param["required"] else write_value(param["default"])


def _snippet(described: dict[str, Any]) -> str:
    """Return YAML with every parameter at its default and every input to wire."""
    family = described["name"].partition(".")[0]
    lines = ["stages:", f"  {family}:", f"    use: {described['name']}"]
    if described["parameters"]:
        lines.append("    with:")
    lines += [
        f"      {param['name']}: " + ("...  # required" if param["required"] else _default(param))
        for param in described["parameters"]
    ]
    if described["inputs"]:
        lines.append("    in:")
    for port in described["inputs"]:
        note = "optional" if port["open"] else "required"
        lines.append(f"      {port['name']}: STAGE.PORT  # {note}: a port that writes {port['type']}")
    return "\n".join(lines)
