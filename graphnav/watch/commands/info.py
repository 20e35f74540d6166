"""``graphnav info``: describe a log: its content, origin and damage."""

from __future__ import annotations

import json

from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.parameters import command


@command(Options.LOG, *Options.TYPES, Options.JSON)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.cli import short_type
    from graphnav.core.record import find_log
    from graphnav.core.tables import Table, print_folded
    from graphnav.watch.loginfo import as_json, as_text, survey
    from graphnav.watch.loginfo.summary import HEADINGS, damage, rows

    args.load_types()
    info = survey(find_log(args.log))
    if args.json:
        print(json.dumps(as_json(info)))
        return Exit.OK
    print("\n".join(as_text(info)))
    if info.channels:
        cells = [(channel, short_type(type_name), *numbers) for channel, type_name, *numbers in rows(info)]
        print_folded(Table.plain(HEADINGS, cells))
    print("\n".join(damage(info)) or "no damage")
    return Exit.OK
