"""``graphnav hz``: the rate of one channel, by its own stamps and as it arrives."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING

from graphnav.cli.options import add_feed_argument, seconds
from graphnav.cli.status import OK

if TYPE_CHECKING:
    from graphnav.spy import ChannelTraffic, Periods

_EVERY_S = 1.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("channel", metavar="CHANNEL", help="the channel's name")
    add_feed_argument(parser)
    parser.add_argument("--for", dest="for_s", type=seconds, metavar="S", help="end after S seconds (default: Ctrl-C)")


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from graphnav.spy import Feed, Traffic  # noqa: PLC0415

    feed = Feed(args.feed)
    traffic = Traffic(feed.clock)
    printed_s = time.monotonic()
    for heard in feed.listen(args.for_s):
        if heard is not None:
            traffic.hear(heard)
            continue
        traffic.check(args.channel, feed)
        channel = traffic.channels.get(args.channel)
        if channel is not None and channel.count and time.monotonic() - printed_s >= _EVERY_S:
            printed_s = time.monotonic()
            print(_lines(channel), flush=True)
    print(_lines(traffic.find(args.channel, feed, args.for_s)))
    return OK


def _lines(channel: ChannelTraffic) -> str:
    """Return the periods by stamps and, where that is not the same, by arrival; or how long nothing has come."""
    from graphnav.spy import silence_of, volume  # noqa: PLC0415

    heard = ", ".join(volume(channel))
    if channel.is_silent:
        return f"{channel.name}  {silence_of(channel)}; {heard}"
    by_stamp, by_arrival = _text(channel.published), _text(channel.arriving)
    if by_arrival == by_stamp:
        return f"{channel.name}  {by_stamp}; {heard}"
    return f"{channel.name}  by stamp: {by_stamp}\n{channel.name}  by arrival: {by_arrival}; {heard}"


def _text(periods: Periods | None) -> str:
    """Return periods as ``ros2 topic hz`` prints them."""
    if periods is None:
        return "no rate yet"
    text = f"average rate: {periods.rate_hz:.3f}"
    if periods.std_s is not None:
        text += f", min: {periods.min_s:.3f}s max: {periods.max_s:.3f}s std dev: {periods.std_s:.5f}s"
    return f"{text} window: {periods.n}"
