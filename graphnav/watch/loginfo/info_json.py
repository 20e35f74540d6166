"""The summary of a log as JSON."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from graphnav.watch.loginfo.survey import ChannelInfo, LogInfo


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
