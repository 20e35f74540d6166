"""``graphnav spy``: every channel of a live run or of a log, with type, rate, size and contents."""

from __future__ import annotations

import argparse
import json
import time
from typing import TYPE_CHECKING

from graphnav.cli.options import add_feed_argument, add_types_option, load_types_of, seconds
from graphnav.cli.status import OK

if TYPE_CHECKING:
    from rich.console import Console

    from graphnav.spy import Feed, Traffic

_REFRESH_S = 0.5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_feed_argument(parser)
    parser.add_argument(
        "--once", action="store_true", help="listen for a while, list the channels with their fields and end"
    )
    parser.add_argument("--json", action="store_true", help="print JSON, for programs; implies --once")
    parser.add_argument(
        "--for", dest="for_s", type=seconds, default=2.5, metavar="S", help="how long --once listens (default: 2.5 s)"
    )
    add_types_option(parser)


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from rich.console import Console  # noqa: PLC0415

    from graphnav.spy import Feed, Traffic, as_json, as_text  # noqa: PLC0415

    load_types_of(args)
    feed = Feed(args.feed)
    traffic = Traffic(feed.clock)
    console = Console(highlight=False, soft_wrap=True)
    if feed.is_live and not (args.once or args.json):
        _watch(feed, traffic, console)
        return OK
    for heard in feed.listen(args.for_s):
        if heard is not None:
            traffic.hear(heard)
    if not traffic.channels:
        raise feed.silence(args.for_s)
    if args.json:
        print(json.dumps(as_json(traffic, feed.name)))
        return OK
    heading = f"{feed.name}: {len(traffic.channels)} channels" + (f" in {args.for_s:g} s" if feed.is_live else "")
    console.print(as_text(traffic, heading + (f"; {feed.torn}" if feed.torn else "")))
    return OK


def _watch(feed: Feed, traffic: Traffic, console: Console) -> None:
    """Show what goes by, a line a channel, until Ctrl-C."""
    from rich.live import Live  # noqa: PLC0415

    from graphnav.spy import as_text  # noqa: PLC0415

    shown_s = 0.0
    with Live(console=console, auto_refresh=False) as live:
        for heard in feed.listen(None):
            if heard is not None:
                traffic.hear(heard)
            elif time.monotonic() - shown_s > _REFRESH_S:
                shown_s = time.monotonic()
                heading = f"{feed.name}: {len(traffic.channels)} channels"
                live.update(as_text(traffic, heading, with_fields=False), refresh=True)
