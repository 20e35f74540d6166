"""``graphnav echo``: the messages of one channel as they come, arrays summarised."""

from __future__ import annotations

import argparse
import json

from graphnav.cli.options import add_feed_argument, count, seconds
from graphnav.cli.status import OK


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("channel", metavar="CHANNEL", help="the channel's name")
    add_feed_argument(parser)
    parser.add_argument("-n", dest="count", type=count, metavar="N", help="end after N messages")
    parser.add_argument("--for", dest="for_s", type=seconds, metavar="S", help="end after S seconds (default: Ctrl-C)")
    parser.add_argument("--json", action="store_true", help="print one JSON object a message, for programs")


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from graphnav.spy import Feed, Traffic, described, size_of, summarised  # noqa: PLC0415

    feed = Feed(args.feed)
    traffic = Traffic(feed.clock)
    for heard in feed.listen(args.for_s):
        if heard is None:
            traffic.check(args.channel, feed)
            continue
        channel = traffic.hear(heard)
        if heard.channel != args.channel:
            continue
        fields = summarised(channel.values or {}) if channel.decodes else None
        if args.json:
            print(json.dumps({"type": channel.type_name, "bytes": len(heard.data), "fields": fields}), flush=True)
        else:
            contents = ["    undecodable"] if fields is None else described(fields)
            head = f"{heard.channel}  {channel.type_name or 'unknown type'}, {size_of(len(heard.data))}"
            print("\n".join([head, *contents]), flush=True)
        if channel.count == args.count:
            return OK
    traffic.find(args.channel, feed, args.for_s)
    return OK
