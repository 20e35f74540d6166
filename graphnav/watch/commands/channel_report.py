"""Base of ``hz`` and ``bw``: listen to one or all channels, report once a second and at the end."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.watch.commands.listening import TIMEOUT_S, ReportTimes, Timeout
from graphnav.watch.commands.options import FEED, channel_and_feed

if TYPE_CHECKING:
    from graphnav.core.tables import Table
    from graphnav.watch.feed import Feed, Watch, WatchedChannel

_JSON_S = 2.5

PARAMETERS = (
    Options.CHANNEL.but(nargs="?", help="the channel's name (default: all channels)"),
    FEED,
    TIMEOUT_S,
    Options.FOR_S,
    Options.JSON.but(help=f"print one JSON document at the end, for programs; --for then defaults to {_JSON_S:g} s"),
    *Options.TYPES,
    Shared.TRUST,
)


def json_keys(keys: str) -> str:
    """Return the text below the help; ``keys`` documents the JSON keys of a channel."""
    return (
        f'--json prints {{"feed": ..., "dropped_packets": N, "channels": {{NAME: {{...}}}}}}; of each channel:\n{keys}'
    )


def report(
    args: CommandArguments,
    line: Callable[[WatchedChannel], str],
    table: Callable[[Watch], Table],
    as_json: Callable[[WatchedChannel], dict[str, Any]],
) -> int:
    """Run a command that prints a line for one channel, a table of all, or either as JSON.

    Raises GraphnavError where nothing was received, or nothing for as long as ``--timeout`` allows, UserError where a
    run is received that has no such channel.
    """
    from graphnav.core.notices import print_notice
    from graphnav.core.tables import print_folded
    from graphnav.watch.commands.listening import complete
    from graphnav.watch.feed import MAX_CHANNELS, Feed, Watch

    catalog = args.catalog()
    args.load_types(catalog)
    name, source = channel_and_feed(args)
    feed = complete(
        Feed(source, None if name is None else [name]), catalog, args.plugins, None if name is None else [name]
    )
    watch = Watch(feed.clock, name)
    for_s = _JSON_S if args.json and args.for_s is None else args.for_s
    times, timeout = ReportTimes(for_s), Timeout(args.timeout_s, feed, watch, name)
    for received in feed.listen(for_s):
        if received is not None:
            watch.receive(received)
            if name in {None, received.channel}:
                timeout.note()
            if name is None and watch.overflow == 1:
                print_notice(f"only the first {MAX_CHANNELS} channels are measured")
            continue
        if name is not None:
            watch.check(name, feed)
        timeout.check()
        if args.json or not times.is_due():
            continue
        if name is None and watch.channels:
            print_folded(table(watch))
        elif name is not None and name in watch.channels and watch.channels[name].count:
            print(line(watch.channels[name]), flush=True)
    if name is not None:
        channels = {name: watch.find(name, feed, for_s)}
    elif not watch.channels:
        raise feed.silence(for_s)
    else:
        channels = watch.channels
    _print_end(args, feed, channels, line, table(watch) if name is None else None, as_json)
    return Exit.OK


def _print_end(
    args: CommandArguments,
    feed: Feed,
    channels: Mapping[str, WatchedChannel],
    line: Callable[[WatchedChannel], str],
    table: Table | None,
    as_json: Callable[[WatchedChannel], dict[str, Any]],
) -> None:
    """Print the last report: of one channel a line, of all a table, either as JSON."""
    from graphnav.core.tables import print_folded

    if args.json:
        told = {name: as_json(channels[name]) for name in sorted(channels)}
        print(json.dumps({"feed": feed.name, "dropped_packets": feed.dropped_packets(), "channels": told}))
    elif table is None:
        print(*map(line, channels.values()), sep="\n")
    else:
        print_folded(table)
