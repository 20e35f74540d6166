"""``graphnav info``: describe a log: its content, origin and damage."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from graphnav.core.cli.options import add_types_option, load_types_of
from graphnav.core.cli.status import OK


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("log", metavar="LOG", type=Path, help="a log, also of lcm-logger, or a run folder")
    add_types_option(parser)
    parser.add_argument("--json", action="store_true", help="print JSON, for programs")


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from graphnav.core.cli.tables import TextTable, print_table
    from graphnav.core.cli.type_names import short_type
    from graphnav.core.record import find_log
    from graphnav.watch.loginfo import as_json, as_text, survey
    from graphnav.watch.loginfo.info_text import HEADINGS, damage, rows

    load_types_of(args)
    info = survey(find_log(args.log))
    if args.json:
        print(json.dumps(as_json(info)))
        return OK
    print("\n".join(as_text(info)))
    if info.channels:
        table = TextTable(*HEADINGS)
        for channel, type_name, *numbers in rows(info):
            table.add_text(channel, short_type(type_name), *numbers)
        print_table(table)
    print("\n".join(damage(info)) or "no damage")
    return OK
