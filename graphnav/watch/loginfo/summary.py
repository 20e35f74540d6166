"""The summary of a log as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

from graphnav.core.errors import shown_name
from graphnav.core.runner import size_text
from graphnav.watch.loginfo.log_origin import LogOrigin
from graphnav.watch.loginfo.survey import ChannelInfo, LogInfo

HEADINGS = ("channel", "type", "messages", "rate", "size", "total", "lost")
"""The headings of `rows`."""
_MAX_SHOWN = 10
_SHOWN_VERSIONS = ("graphnav", "lcm", "numpy", "instruction set")
_MAX_TIME_US = 253_402_300_799_000_000
"""End of the year 9999."""


def as_json(info: LogInfo) -> dict[str, Any]:
    """Return the summary as JSON-compatible values; unknown values are null."""
    return {
        "log": str(info.path),
        "bytes": info.n_bytes,
        "messages": info.n_messages,
        "begin_us": info.begin_us,
        "is_wall_time": info.is_wall_time,
        "duration_s": info.duration_us / 1e6,
        "stamp_jumps": info.n_jumps,
        "made_by": asdict(info.origin) if info.origin is not None else None,
        "unfinished": info.unfinished,
        "topics_without_messages": list(info.silent),
        "completion_hint": info.completion_hint,
        "channels": {channel.name: _channel(channel) for channel in info.channels},
        "gaps": [{"from_us": gap.from_us, "until_us": utime, "messages": gap.n_messages} for utime, gap in info.gaps],
        "damaged": [{"at": damaged.at, "bytes": damaged.n_bytes} for damaged in info.damaged],
        "truncated": {"at": info.truncated.at, "bytes": info.truncated.n_bytes} if info.truncated is not None else None,
    }


def _channel(channel: ChannelInfo) -> dict[str, Any]:
    return {
        "type": channel.type_name,
        "is_known": channel.kind is not None,
        "fingerprint": channel.fingerprint_hex,
        "messages": channel.count,
        "rate_hz": channel.rate_hz,
        "first_s": channel.first_s,
        "last_s": channel.received_s,
        "bytes": channel.n_bytes,
        "min_bytes": channel.min_bytes,
        "max_bytes": channel.max_bytes,
        "lost": channel.lost,
        "lost_since_restart": channel.lost_since_restart,
        "restarts": channel.n_restarts,
        "undecodable": channel.undecodable,
    }


def as_text(info: LogInfo) -> list[str]:
    """Return the lines above the table of channels."""
    messages = f"{info.n_messages:,} messages" if info.n_messages != 1 else "1 message"
    channels = f"{len(info.channels)} channels" if len(info.channels) != 1 else "1 channel"
    log = shown_name(str(info.path))
    lines = [f"{log}: {size_text(info.n_bytes)}, {messages} on {channels}, {info.duration_us / 1e6:.3f} s"]
    lines.append(_begin(info) if info.n_messages else "the log holds no messages")
    if info.origin is not None:
        lines += _origin_lines(info.origin)
    if info.unfinished:
        lines.append(shown_name(info.unfinished))
    if info.silent:
        lines.append(f"topics without messages: {', '.join(map(shown_name, info.silent))}")
    if info.completion_hint:
        lines.append(f"its large messages are not recorded, a replay recomputes them; {info.completion_hint}")
    return lines


def rows(info: LogInfo) -> list[tuple[str, ...]]:
    """Return one row per channel."""
    return [
        (
            shown_name(channel.name),
            _type(channel),
            f"{channel.count:,}",
            f"{channel.rate_hz:.2f} Hz" if channel.rate_hz is not None else "",
            _size(channel),
            size_text(channel.n_bytes),
            f"{channel.lost:,}" if channel.lost is not None else "",
        )
        for channel in info.channels
    ]


def damage(info: LogInfo) -> Iterator[str]:
    """Yield one line per loss or damage; none for a complete log."""
    for channel in info.channels:
        name = shown_name(channel.name)
        if channel.undecodable and channel.undecodable < channel.count:
            of = f"{channel.undecodable:,} of {channel.count:,} messages"
            yield f"{name}: {of} cannot be decoded as {channel.type_name or 'the type of the first message'}"
        elif channel.undecodable:
            yield f"{name}: no message can be decoded"
        if channel.n_restarts:
            yield f"{name}: sequence numbers restarted {_times(channel.n_restarts)}"
    for utime, gap in info.gaps[:_MAX_SHOWN]:
        from_s, until_s = ((us - info.begin_us) / 1e6 for us in (gap.from_us, utime))
        what = f"{gap.n_messages:,} messages between {from_s:.3f} s and {until_s:.3f} s were not recorded"
        yield f"{what}: {shown_name(gap.reason)}"
    if info.n_jumps:
        yield f"{info.n_jumps:,} timestamps jump: the clock was set, or they are damaged"
    yield from map(str, info.damaged[:_MAX_SHOWN])
    if len(info.damaged) > _MAX_SHOWN:
        rest = info.damaged[_MAX_SHOWN:]
        yield f"{sum(one.n_bytes for one in rest)} bytes in {len(rest)} more places are not events"
    if info.truncated is not None:
        yield str(info.truncated)


def _begin(info: LogInfo) -> str:
    if not info.is_wall_time:
        return f"simulated time from {info.begin_us / 1e6:.3f} s"
    if info.begin_us > _MAX_TIME_US:
        return f"begins {info.begin_us} us after 1970-01-01"
    return f"begins {datetime.fromtimestamp(info.begin_us / 1e6, UTC):%Y-%m-%d %H:%M:%S.%f} UTC"


def _origin_lines(origin: LogOrigin) -> Iterator[str]:
    words = [f"{origin.n_stages} stages" if origin.n_stages is not None else "", f"seed {origin.seed}"]
    words += [f"run {origin.run_id}"] if origin.run_id else []
    words += [f"outcome {origin.outcome}"] if origin.outcome else []
    words += [f"{name} {origin.versions[name]}" for name in _SHOWN_VERSIONS if name in origin.versions]
    graph = f"the graph {origin.name}" if origin.name else "a graph whose name is not recorded"
    yield shown_name(f"run of {graph}: " + ", ".join(filter(None, words)))
    if origin.about:
        yield shown_name(f"  {origin.about}")


def _type(channel: ChannelInfo) -> str:
    if channel.kind is not None or channel.fingerprint_hex is None:
        return shown_name(channel.type_name or "not an LCM type")
    fingerprint = f"fingerprint {channel.fingerprint_hex}"
    return f"{shown_name(channel.type_name)} ({fingerprint})" if channel.type_name else f"unknown, {fingerprint}"


def _size(channel: ChannelInfo) -> str:
    if channel.min_bytes == channel.max_bytes:
        return size_text(channel.min_bytes)
    return f"{size_text(channel.min_bytes)} to {size_text(channel.max_bytes)}"


def _times(n: int) -> str:
    return "once" if n == 1 else f"{n:,} times"
