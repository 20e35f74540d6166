"""``graphnav new-stage``: write a working one-file plugin and its test."""

from __future__ import annotations

import argparse
import keyword
from pathlib import Path

from graphnav.cli.status import OK
from graphnav.errors import UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("family", metavar="FAMILY", help="what it is for: flow, plane, steer, … or a new family")
    parser.add_argument("name", metavar="NAME", help="what it is called in graphs: my_detector")
    parser.add_argument("-o", dest="folder", type=Path, default=Path(), metavar="DIR", help="where (default: here)")


def main(args: argparse.Namespace) -> int:
    """Run the command; nothing is overwritten."""
    from graphnav.catalog import Catalog  # noqa: PLC0415
    from graphnav.cli.stage_templates import stage_text, test_text  # noqa: PLC0415
    from graphnav.spec.spec import STAGE_NAME  # noqa: PLC0415

    for word in (args.family, args.name):
        if not STAGE_NAME.fullmatch(word) or keyword.iskeyword(word):
            raise UserError.of(f"'{word}' cannot be a name", "use small letters, digits and _, beginning with a letter")
    catalog = Catalog()
    if args.family in catalog.families() and args.name in catalog.names(args.family):
        raise UserError.of(f"'{args.family}.{args.name}' is there already", "choose another name")
    cls = "".join(part.capitalize() for part in args.name.split("_"))
    texts = {
        args.folder / f"{args.name}.py": stage_text(args.family, cls),
        args.folder / f"test_{args.name}.py": test_text(args.family, args.name, cls),
    }
    for path in texts:
        if path.exists():
            raise UserError.of(f"{path} is there already", "choose another name, or another folder with -o")
    try:
        args.folder.mkdir(parents=True, exist_ok=True)
        for path, text in texts.items():
            path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise UserError.of(f"cannot write into {args.folder}: {error.strerror}", "choose another with -o") from error
    stage_file, test_file = texts
    print(f"{stage_file}: a working stage, {args.family}.{args.name}")
    print(f"{test_file}: its test; run it with 'python -m pytest {test_file}'")
    swap = f"{args.family if args.family != 'world' else 'robot'}={args.family}.{args.name}"
    print(f"Try it: graphnav run GRAPH --plugin {stage_file} --set {swap}")
    return OK
