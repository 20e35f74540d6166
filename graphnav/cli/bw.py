"""``graphnav bw``: the bandwidth of channels and the sizes of their messages."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from graphnav.cli.options import add_channel_and_feed, add_types_option, channel_and_feed, load_types_of, seconds
from graphnav.cli.report_times import ReportTimes
from graphnav.cli.status import OK

if TYPE_CHECKING:
    from graphnav.cli.tables import TextTable
    from graphnav.spy import Bandwidth, Traffic


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_channel_and_feed(parser)
    parser.add_argument("--for", dest="for_s", type=seconds, metavar="S", help="end after S seconds (default: Ctrl-C)")
    add_types_option(parser)


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from graphnav.cli.tables import print_table  # noqa: PLC0415
    from graphnav.spy import Bandwidth, Feed, Traffic  # noqa: PLC0415

    load_types_of(args)
    name, source = channel_and_feed(args)
    feed = Feed(source)
    traffic = Traffic(feed.clock)
    heard_on: dict[str, Bandwidth] = {}
    times = ReportTimes(args.for_s)
    for heard in feed.listen(args.for_s):
        if heard is not None:
            traffic.hear(heard)
            heard_on.setdefault(heard.channel, Bandwidth(is_live=feed.is_live)).hear(heard)
            continue
        if name is None:
            if heard_on and times.is_due():
                print_table(_table(traffic, heard_on))
            continue
        traffic.check(name, feed)
        if name in heard_on and times.is_due():
            print(_line(traffic, name, heard_on[name]), flush=True)
    if name is not None:
        traffic.find(name, feed, args.for_s)
        print(_line(traffic, name, heard_on[name]))
    elif not heard_on:
        raise feed.silence(args.for_s)
    else:
        print_table(_table(traffic, heard_on))
    return OK


def _line(traffic: Traffic, name: str, bandwidth: Bandwidth) -> str:
    """Return what ``ros2 topic bw`` prints, in one line."""
    from graphnav.errors import printable  # noqa: PLC0415
    from graphnav.spy import silence_of, size_of  # noqa: PLC0415

    channel, sizes = traffic.channels[name], bandwidth.sizes
    bounds = f"size min: {size_of(sizes.min_bytes)} mean: {size_of(round(sizes.mean_bytes))}"
    rate = silence_of(channel) if channel.is_silent else _rate(sizes.bytes_per_s) or "no rate yet"
    return f"{printable(name)}  {rate}, {bounds} max: {size_of(sizes.max_bytes)} window: {sizes.n}"


def _table(traffic: Traffic, heard_on: dict[str, Bandwidth]) -> TextTable:
    from graphnav.cli.tables import TextTable  # noqa: PLC0415
    from graphnav.errors import printable  # noqa: PLC0415
    from graphnav.spy import size_of  # noqa: PLC0415

    table = TextTable("channel", "bandwidth", "size min", "mean", "max", "count", "note")
    total = 0.0
    for name in sorted(traffic.channels):
        if name not in heard_on:
            table.add_text(printable(name), "", "", "", "", "0", "not heard")
            continue
        channel, sizes = traffic.channels[name], heard_on[name].sizes
        bytes_per_s = None if channel.is_silent else sizes.bytes_per_s
        total += bytes_per_s or 0.0
        bounds = map(size_of, (sizes.min_bytes, round(sizes.mean_bytes), sizes.max_bytes))
        note = f"silent {channel.silent_s or 0.0:.1f} s" if channel.is_silent else ""
        table.add_text(printable(name), _rate(bytes_per_s), *bounds, str(channel.count), note)
    table.add_text("all", _rate(total), "", "", "", "", "")
    return table


def _rate(bytes_per_s: float | None) -> str:
    from graphnav.spy import size_of  # noqa: PLC0415

    return "" if bytes_per_s is None else f"{size_of(round(bytes_per_s))}/s"
