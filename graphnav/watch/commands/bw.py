"""``graphnav bw``: the bandwidth of channels and the sizes of their messages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graphnav.core.cli import CommandArguments
from graphnav.core.parameters import command
from graphnav.watch.commands import channel_report

if TYPE_CHECKING:
    from graphnav.core.tables import Table
    from graphnav.watch.feed import Watch, WatchedChannel

_KEYS = """\
  type, messages, lost    as in spy: messages received, and missing by their sequence numbers
  lost_since_restart      of these, since a sender restarted its numbers
  bytes_per_s             bandwidth; null below two messages and on a silent channel
  bytes                   of the newest message
  min_bytes, mean_bytes, max_bytes
                          of the messages of the last 10 s, in a log of the last 10,000; null before the first
  silent_s                since the newest arrived; null in a log
"""


@command(*channel_report.PARAMETERS, examples=channel_report.json_keys(_KEYS))
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.watch.spy import sizes_as_json

    return channel_report.report(args, _line, _table, sizes_as_json)


def _line(channel: WatchedChannel) -> str:
    """Return the output of ``ros2 topic bw`` in one line."""
    from graphnav.core.errors import shown_name
    from graphnav.watch.spy import silence_of, size_of

    sizes = channel.sizes
    bounds = f"size min: {size_of(sizes.min_bytes)} mean: {size_of(round(sizes.mean_bytes))}"
    rate = silence_of(channel) if channel.is_silent else _rate(channel.bytes_per_s) or "no rate yet"
    return f"{shown_name(channel.name)}  {rate}, {bounds} max: {size_of(sizes.max_bytes)} window: {sizes.n}"


def _table(watch: Watch) -> Table:
    from graphnav.core.errors import shown_name
    from graphnav.core.tables import Table
    from graphnav.watch.spy import size_of

    rows = list[tuple[str, ...]]()
    total = 0.0
    for name in sorted(watch.channels):
        channel = watch.channels[name]
        if not channel.count:
            rows.append((shown_name(name), "", "", "", "", "0", "not received"))
            continue
        sizes = channel.sizes
        total += channel.bytes_per_s or 0.0
        bounds = map(size_of, (sizes.min_bytes, round(sizes.mean_bytes), sizes.max_bytes))
        note = f"silent {channel.silent_s or 0.0:.1f} s" if channel.is_silent else ""
        rows.append((shown_name(name), _rate(channel.bytes_per_s), *bounds, str(channel.count), note))
    rows.append(("all", _rate(total), "", "", "", "", ""))
    return Table.plain(("channel", "bandwidth", "size min", "mean", "max", "count", "note"), rows)


def _rate(bytes_per_s: float | None) -> str:
    from graphnav.watch.spy import size_of

    return "" if bytes_per_s is None else f"{size_of(round(bytes_per_s))}/s"
