"""The channels of a watch as text and JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rich.text import Text

from graphnav.core.errors import shown_name
from graphnav.core.field_summary import declared, described, summarised
from graphnav.core.record import Periods
from graphnav.watch.feed import MAX_CHANNELS, MAX_RUNS, Feed, Watch, WatchedChannel
from graphnav.watch.fields.plain_values import plain

_APART_RATIO = 0.05
"""Arrival rates that differ by more than this from the rate of the timestamps are shown."""


def as_json(watch: Watch, feed: Feed) -> dict[str, Any]:
    """Return the statistics of all channels as JSON-compatible values."""
    return {
        "feed": feed.name,
        "runs": watch.announcements.ids,
        "messages": watch.count,
        "undecodable": watch.undecodable,
        "overflow": watch.overflow,
        "dropped_packets": feed.dropped_packets(),
        "channels": {name: _channel_as_json(watch.channels[name]) for name in sorted(watch.channels)},
    }


def _channel_as_json(channel: WatchedChannel) -> dict[str, Any]:
    """Return the statistics of one channel."""
    return {
        **rates_as_json(channel),
        **sizes_as_json(channel),
        "undecodable": channel.undecodable,
        "fields": plain(_fields_of_channel(channel)),
    }


def rates_as_json(channel: WatchedChannel) -> dict[str, Any]:
    """Return the rates of one channel, by message timestamps and by arrival (``wall``)."""
    return {
        **_volume_as_json(channel),
        "rate_hz": channel.rate_hz,
        "wall_rate_hz": channel.wall_rate_hz,
        **_periods_as_json("period", channel.published),
        **_periods_as_json("wall_period", channel.arriving),
    }


def sizes_as_json(channel: WatchedChannel) -> dict[str, Any]:
    """Return the sizes of one channel's messages and their bytes per second."""
    sizes = channel.sizes if channel.count else None
    return {
        **_volume_as_json(channel),
        "bytes": channel.last_bytes,
        "bytes_per_s": channel.bytes_per_s,
        **{name: getattr(sizes, name, None) for name in ("min_bytes", "mean_bytes", "max_bytes")},
    }


def _volume_as_json(channel: WatchedChannel) -> dict[str, Any]:
    return {
        "type": channel.type_name,
        "messages": channel.count,
        "lost": channel.lost,
        "lost_since_restart": channel.lost_since_restart,
        "silent_s": channel.silent_s,
    }


def _periods_as_json(prefix: str, periods: Periods | None) -> dict[str, float | None]:
    return {f"{prefix}_{name}": getattr(periods, name, None) for name in ("min_s", "max_s", "std_s")}


def as_text(watch: Watch, heading: str, *, with_fields: bool = True) -> Text:
    """Return the statistics of all channels as text; without the fields one line per channel."""
    lines = [Text(heading), *(Text(f"run {shown_name(run)}", "bold") for run in watch.announcements.ids)]
    for name in sorted(watch.channels):
        channel = watch.channels[name]
        lines.append(Text(shown_name(name), "bold cyan") + Text("  " + ", ".join(_summary_of(channel)), "default"))
        if with_fields:
            lines += map(Text, described(_fields_of_channel(channel)))
    if watch.announcements.has_forgotten:
        lines.append(Text(f"only the newest {MAX_RUNS} runs are kept"))
    if watch.overflow:
        lines.append(Text(f"{watch.overflow} messages on channels beyond the first {MAX_CHANNELS} were not kept"))
    return Text("\n").join(lines)


def _fields_of_channel(channel: WatchedChannel) -> dict[str, Any]:
    """Return the fields of a channel's newest message, or their declared types before the first message."""
    if channel.values is not None:
        return summarised(channel.values)
    return declared(channel.lcm_class) if channel.lcm_class is not None else {}


def _summary_of(channel: WatchedChannel) -> Iterator[str]:
    """Yield phrases about one channel: type, amount, rate, size."""
    yield shown_name(channel.type_name or "unknown type")
    if channel.is_silent:
        yield silence_of(channel)
    elif channel.rate_hz is not None:
        wall_hz = channel.wall_rate_hz
        is_apart = wall_hz is not None and abs(wall_hz / channel.rate_hz - 1) > _APART_RATIO
        yield f"{channel.rate_hz:.2f} Hz" + (f" (arriving at {wall_hz:.2f} Hz)" if is_apart else "")
    yield from volume(channel)


def silence_of(channel: WatchedChannel) -> str:
    """Return a phrase about the silence of a channel."""
    return f"no new messages for {channel.silent_s or 0.0:.1f} s"


def volume(channel: WatchedChannel) -> Iterator[str]:
    """Yield phrases about the received and missing messages of one channel."""
    if not channel.count:
        yield "not received"
        return
    yield size_of(channel.last_bytes)
    yield "1 message" if channel.count == 1 else f"{channel.count} messages"
    if channel.lost:
        yield f"{channel.lost} lost"
    if channel.undecodable:
        yield f"{channel.undecodable} undecodable"


def size_of(n_bytes: int) -> str:
    """Format a number of bytes with a unit."""
    return (
        f"{n_bytes} B" if n_bytes < 1000 else f"{n_bytes / 1000:.1f} kB" if n_bytes < 1e6 else f"{n_bytes / 1e6:.2f} MB"
    )
