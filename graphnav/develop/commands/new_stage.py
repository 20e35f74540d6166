"""``graphnav new-stage``: write a working one-file plugin and its test."""

from __future__ import annotations

import argparse
import keyword
import re
from importlib.util import find_spec
from pathlib import Path

from graphnav import UserError
from graphnav.core.cli import Exit
from graphnav.core.parameters import Parameter, command


@command(
    Parameter(
        "family",
        metavar="FAMILY",
        help="family of the stage: flow, plane, steer, … or a new one",
        offers="families",
    ),
    Parameter("name", metavar="NAME", help="name of the stage in graphs: my_detector"),
    Parameter("folder", "-o", type=Path, default=Path(), metavar="DIR", help="output folder (default: this one)"),
)
def main(args: argparse.Namespace) -> int:
    """Run the command; existing files are not overwritten."""
    from graphnav.core.catalog import ADAPTERS, Catalog
    from graphnav.core.messages import snake_case
    from graphnav.core.spec import STAGE_NAME
    from graphnav.develop.commands.stage_templates import hints, stage_text, test_text

    for word in (args.family, args.name):
        if not re.fullmatch(STAGE_NAME, word) or keyword.iskeyword(word):
            raise UserError.of(f"'{word}' cannot be a name", "use small letters, digits and _, beginning with a letter")
    if args.family == ADAPTERS:
        raise UserError.of(f"the family '{ADAPTERS}' is reserved for adapters", "choose another family")
    cls = "".join(part.capitalize() for part in args.name.split("_"))
    if snake_case(cls) != args.name:
        what = f"'{args.name}' cannot be a name: its class {cls} would be named '{snake_case(cls)}'"
        raise UserError.of(what, f"choose another name, such as '{snake_case(cls)}'")
    catalog = Catalog()
    if args.family in catalog.families() and args.name in catalog.names(args.family):
        raise UserError.of(f"'{args.family}.{args.name}' already exists", "choose another name")
    if find_spec(args.name) is not None:
        what = f"'{args.name}' is the name of a Python module, which {args.name}.py would hide from its test"
        raise UserError.of(what, "choose another name")
    texts = {
        args.folder / f"{args.name}.py": stage_text(args.family, cls),
        args.folder / f"test_{args.name}.py": test_text(args.family, args.name, cls),
    }
    for path in texts:
        if path.exists():
            raise UserError.of(f"{path} already exists", "choose another name, or another folder with -o")
    try:
        args.folder.mkdir(parents=True, exist_ok=True)
        for path, text in texts.items():
            path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise UserError.of(f"cannot write into {args.folder}: {error.strerror}", "choose another with -o") from error
    print("\n".join(hints(args.family, args.name, *texts)))
    return Exit.OK
