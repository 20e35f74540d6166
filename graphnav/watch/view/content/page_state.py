"""The state shown on every page: runs, stages, channels, as JSON-compatible values."""

from __future__ import annotations

from typing import Any

from graphnav.watch.spy import health_as_json
from graphnav.watch.view.channel import WatchedChannel
from graphnav.watch.view.log_source import LogSource
from graphnav.watch.view.source import Source

_MAX_SHOWN_NAME = 200


def state_of(source: Source, run_id: str | None) -> dict[str, Any]:
    """Return all counts, and channels, guards and health of the run ``run_id``; the caller holds the source's lock."""
    watch = source.watch
    health = health_as_json(watch.health, source.name)
    channels = watch.channels_of(run_id)
    return {
        "failure": source.failure,
        "run_id": run_id,
        "runs": list(watch.announcements.runs),
        "run": next((run for run in health["runs"] if run["run_id"] == run_id), None),
        "guards": [guard for guard in health["guards"] if guard["channel"] in channels],
        "channels": [channel_state(channel) for channel in channels.values()],
        "messages": watch.count,
        "undecodable": watch.undecodable,
        "untracked": watch.untracked,
        "dropped_packets": source.dropped_packets(),
        "refused": watch.announcements.refused,
        "log": log_state(source) if isinstance(source, LogSource) else None,
    }


def channel_state(channel: WatchedChannel) -> dict[str, Any]:
    """Return the statistics of a channel; ``rate_hz`` is null for a silent or new channel."""
    return {
        "name": channel.name,
        "type": (channel.type_name or "")[:_MAX_SHOWN_NAME],
        "count": channel.count,
        "rate_hz": channel.rate_hz,
        "once": channel.kind is not None and channel.is_single,
        "silent": channel.is_silent,
        "pipeline_ms": None if channel.pipeline_delay_s is None else channel.pipeline_delay_s * 1e3,
        "bytes": channel.last_bytes,
        "lost": channel.lost,
        "undecodable": channel.undecodable,
        "age_s": channel.silent_s,
    }


def log_state(source: LogSource) -> dict[str, Any]:
    """Return the playback state of a log."""
    return {
        "at_s": source.at_s,
        "length_s": source.length_s,
        "playing": source.is_playing,
        "speed": source.speed_ratio,
        "damage": source.damage,
    }
