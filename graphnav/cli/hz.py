"""``graphnav hz``: the rate of one channel, by its own stamps and as it arrives."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING

from graphnav.cli.options import add_feed_argument, seconds
from graphnav.cli.status import OK

if TYPE_CHECKING:
    from graphnav.spy import ChannelTraffic, Feed

_EVERY_S = 1.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("channel", metavar="CHANNEL", help="the channel's name")
    add_feed_argument(parser)
    parser.add_argument("--for", dest="for_s", type=seconds, metavar="S", help="end after S seconds (default: Ctrl-C)")


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from graphnav.spy import Feed, Traffic  # noqa: PLC0415

    feed, traffic = Feed(args.feed), Traffic()
    printed_s = time.monotonic()
    for heard in feed.listen(args.for_s):
        if heard is not None:
            traffic.hear(heard)
            continue
        traffic.check(args.channel, feed)
        channel = traffic.channels.get(args.channel)
        if channel is not None and channel.count and time.monotonic() - printed_s >= _EVERY_S:
            printed_s = time.monotonic()
            print(_line(channel, feed), flush=True)
    print(_line(traffic.find(args.channel, feed, args.for_s), feed))
    return OK


def _line(channel: ChannelTraffic, feed: Feed) -> str:
    from graphnav.spy import volume  # noqa: PLC0415

    rate = "no rate yet" if channel.rate_hz is None else f"{channel.rate_hz:.3f} Hz"
    arriving = f"arriving at {channel.wall_rate_hz:.3f} Hz, " if feed.is_live and channel.wall_rate_hz else ""
    return f"{channel.name}  {rate}, {arriving}{', '.join(volume(channel))}"
