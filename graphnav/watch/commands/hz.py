"""``graphnav hz``: measure the rates of channels, by stamp and by arrival."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graphnav.core.cli import CommandArguments
from graphnav.core.parameters import command
from graphnav.watch.commands import channel_report

if TYPE_CHECKING:
    from graphnav.core.record import Periods
    from graphnav.core.tables import Table
    from graphnav.watch.feed import Watch, WatchedChannel

_KEYS = """\
  type, messages, lost    as in spy: messages received, and missing by their sequence numbers
  lost_since_restart      of these, since a sender restarted its numbers
  rate_hz, wall_rate_hz   by the messages' own stamps, and as they arrived; null where there is none
  period_min_s, period_max_s, period_std_s, wall_period_min_s, ...
                          of the periods between consecutive messages, on either clock
  silent_s                since the newest arrived; null in a log
"""


@command(*channel_report.PARAMETERS, examples=channel_report.json_keys(_KEYS))
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.watch.spy import rates_as_json

    return channel_report.report(args, _lines, _table, rates_as_json)


def _lines(channel: WatchedChannel) -> str:
    """Return the periods by stamp and, if different, by arrival; or the duration of the silence."""
    from graphnav.core.errors import shown_name
    from graphnav.watch.spy import silence_of, volume

    name, received = shown_name(channel.name), ", ".join(volume(channel))
    if channel.is_silent:
        return f"{name}  {silence_of(channel)}; {received}"
    by_stamp, by_arrival = _text(channel.published), _text(channel.arriving)
    if by_arrival == by_stamp:
        return f"{name}  {by_stamp}; {received}"
    return f"{name}  by stamp: {by_stamp}\n{name}  by arrival: {by_arrival}; {received}"


def _text(periods: Periods | None) -> str:
    """Return periods in the format of ``ros2 topic hz``."""
    if periods is None:
        return "no rate yet"
    text = f"average rate: {periods.rate_hz:.3f}"
    if periods.std_s is not None:
        text += f", min: {periods.min_s:.3f}s max: {periods.max_s:.3f}s std dev: {periods.std_s:.5f}s"
    return f"{text} window: {periods.n}"


def _table(watch: Watch) -> Table:
    """Return a row for each channel; periods are by stamp."""
    from graphnav.core.errors import shown_name
    from graphnav.core.tables import Table

    rows = []
    for name in sorted(watch.channels):
        channel = watch.channels[name]
        periods, arriving = channel.published, channel.arriving
        steps = (None,) * 3 if periods is None else (periods.min_s, periods.max_s, periods.std_s)
        cells = (_rate(periods), _rate(arriving), *map(_ms, steps), str(channel.count), _note(channel))
        rows.append((shown_name(name), *cells))
    header = ("channel", "stamp Hz", "arrival", "min ms", "max ms", "std ms", "count", "note")
    return Table.plain(header, rows)


def _rate(periods: Periods | None) -> str:
    return "" if periods is None else f"{periods.rate_hz:.2f}"


def _ms(period_s: float | None) -> str:
    return "" if period_s is None else f"{period_s * 1e3:.1f}"


def _note(channel: WatchedChannel) -> str:
    if not channel.count:
        return "not received"
    if channel.is_silent:
        return f"silent {channel.silent_s or 0.0:.1f} s"
    return f"{channel.lost} lost" if channel.lost else ""
