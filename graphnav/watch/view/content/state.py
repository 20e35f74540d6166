"""The state that every page shows, as JSON-compatible values: runs, stages, channels, and the map of the world."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import graphnav_lcm

from graphnav import Map, Scene
from graphnav.core.codec import DecodeError, decode
from graphnav.watch.feed import LogFeed, Received, WatchedChannel
from graphnav.watch.spy import health_as_json
from graphnav.watch.view.page_feed import PageFeed

_MAX_SHOWN_NAME = 200
_MAX_VERTICES = 20_000


def state_of(feed: PageFeed, run_id: str | None) -> dict[str, Any]:
    """Return all counts, and channels, guards and health of the run ``run_id``; the caller holds the feed's lock."""
    watch = feed.state.watch
    health = health_as_json(feed.state.health, feed.name)
    channels = feed.state.channels_of(run_id)
    return {
        "failure": feed.failure,
        "losses": feed.losses,
        "run_id": run_id,
        "runs": list(watch.announcements.runs),
        "run": next((run for run in health["runs"] if run["run_id"] == run_id), None),
        "guards": [guard for guard in health["guards"] if guard["channel"] in channels],
        "channels": [channel_state(channel) for channel in channels.values()],
        "messages": watch.count,
        "undecodable": watch.undecodable,
        "untracked": watch.overflow,
        "dropped_packets": feed.dropped_packets(),
        "refused": watch.announcements.refused,
        "log": None if feed.log is None else log_state(feed.log, feed.damage),
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


def log_state(log: LogFeed, damage: str) -> dict[str, Any]:
    """Return the playback state of a log."""
    return {
        "at_s": log.at_s,
        "length_s": log.length_s,
        "playing": log.is_playing,
        "speed": log.speed_ratio,
        "damage": damage,
    }


def newest_map(channels: Iterable[WatchedChannel]) -> Received | None:
    """Return the newest map message on some channels."""
    maps = (one.newest for one in channels if one.newest and one.kind and one.kind.lcm_class is graphnav_lcm.map_t)
    return max(maps, key=lambda received: received.at_s, default=None)


def floor_map(data: bytes) -> dict[str, Any] | None:
    """Return the areas of the map and the robot's body; None if the message is not a map or too large to be drawn.

    The page draws areas in the order in which they are given: moving obstacles in their own frames, and what the camera
    sees of the floor in that of the robot.
    """
    try:
        world = decode(Map, data)[2]
    except DecodeError:
        return None
    lengths = (len(world.vertices_m), len(world.goal_m), len(world.footprint_m), len(world.kind))
    if max(lengths) > _MAX_VERTICES or len(world.body) != len(world.vertices_m) or world.not_finite():
        return None
    scene = Scene(world)
    areas = [*scene.fixed, *scene.moving, *([scene.seen] if scene.seen is not None else [])]
    return {
        "areas": [None if one is None else {"role": one.role, "outline": one.outline_m.tolist()} for one in areas],
        "robot_radius_m": scene.robot_radius_m,
        "robot_outline": None if scene.robot is None else scene.robot.outline_m.tolist(),
    }
