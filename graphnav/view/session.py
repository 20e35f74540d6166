"""What one page is sent: only what it shows, only the newest, and only what has changed."""

from __future__ import annotations

import json
import time
from typing import Any

import numpy as np

from graphnav.catalog import Catalog
from graphnav.errors import GraphnavError
from graphnav.messages import About
from graphnav.pictures import Pictures
from graphnav.view.announced_graph import announced_graph
from graphnav.view.channel import WatchedChannel
from graphnav.view.details import Moment, details_of, picture_of
from graphnav.view.floor_map import floor_map
from graphnav.view.layout import layout_of
from graphnav.view.log_source import LogSource
from graphnav.view.orders import View
from graphnav.view.source import Source
from graphnav.view.state import finite, state_of
from graphnav.view.watch import Watch

_STATE_S = 0.5

Update = dict[str, Any]


class Session:
    """Gathers the updates of one page; one thread at a time calls it."""

    def __init__(self, source: Source, catalog: Catalog, pictures: Pictures) -> None:
        self.view = View()
        self._source, self._catalog, self._pictures = source, catalog, pictures
        self._state_due_s = 0.0
        self._watch: Watch | None = None
        self._forget_sent()
        self._sent_graph: tuple[str, tuple[str, ...]] | None = None

    def greeting(self) -> str:
        """Return the first message: what is watched."""
        log = self._source if isinstance(self._source, LogSource) else None
        hello = {"kind": "hello", "name": self._source.name, "log": log is not None}
        return json.dumps(hello | ({"length_s": log.length_s} if log else {}), allow_nan=False)

    def update(self, number: int) -> tuple[str, bytes | None] | None:
        """Return the update called ``number`` and the picture that belongs to it, None where nothing has changed."""
        view, update, picture, about, moment = self.view, {}, None, None, None
        with self._source.lock:
            watch = self._source.watch
            if watch is not self._watch:
                self._watch = watch
                self._forget_sent()
            run_id = watch.announcements.shown(view.run_id, watch.clock())
            if run_id is not None:
                about = watch.announcements.runs[run_id].about
            if (now_s := time.monotonic()) >= self._state_due_s:
                self._state_due_s = now_s + _STATE_S
                update["state"] = state_of(self._source, run_id)
            channel = watch.channels.get(view.channel) if view.channel is not None else None
            if view.channel is not None and (channel.count if channel else 0, view) != self._sent_details:
                self._sent_details = (channel.count if channel else 0, view)
                update["details"] = self._head(view.channel, channel)
                moment = self._moment(watch, channel) if channel else None
            world = watch.channels[watch.map_channel].newest if view.with_map and watch.map_channel else None
            if view.with_map:
                update |= self._track(watch)
        if about is not None and (about.graph_yaml, about.channels) != self._sent_graph:
            update["graph"] = self._graph(about)
        if world is not None and world.data != self._sent_world:
            self._sent_world = world.data
            update["world"] = floor_map(world.data)
        if moment is not None and moment.newest is not None and moment.kind is not None:
            picture = self._open(moment, update["details"], view)
        if not update:
            return None
        update["has_picture"] = picture is not None
        return json.dumps(finite({"kind": "update", "number": number, **update}), allow_nan=False), picture

    def _forget_sent(self) -> None:
        """Send everything again: what is watched began anew."""
        self._state_due_s = 0.0
        self._sent_details: tuple[int, View | None] = (-1, None)
        self._sent_channel: str | None = None
        self._sent_point = 0
        self._sent_world: bytes | None = None
        self._sent_track = (-1, 0)
        self._sent_pose: tuple[float, float, float] | None = None

    def _graph(self, about: About) -> Update:
        self._sent_graph = about.graph_yaml, about.channels
        try:
            return layout_of(announced_graph(about, self._catalog))
        except GraphnavError as error:
            return {"failure": str(error)}

    def _head(self, name: str, channel: WatchedChannel | None) -> Update:
        """Return what a page needs to know of the open channel first, and why there is no more of it, in a word."""
        missing = ""
        if channel is None or not channel.count:
            missing = "unheard"
        elif channel.is_too_large:
            missing = "too large"
        elif channel.kind is None:
            missing = "unknown type"
        is_new = self._sent_channel != name
        if is_new:
            self._sent_channel, self._sent_point = name, 0
        return {"channel": name, "missing": missing, "reset": is_new}

    def _moment(self, watch: Watch, channel: WatchedChannel) -> Moment:
        """Return what the details are made of, as it is now."""
        points = [point for point in channel.history if point[0] > self._sent_point]
        if not channel.history and channel.newest is not None and channel.count > self._sent_point:
            points = [(channel.count, channel.newest)]
        self._sent_point = channel.count
        stamp = _stamp(channel)
        others: dict[type, bytes] = {}
        for other in watch.channels.values():
            if other.kind is None or other.newest is None:
                continue
            if other.kind.lcm_class not in others or _stamp(other) == stamp:
                others[other.kind.lcm_class] = other.newest.data
        path = np.array(watch.track.points_m, np.float64).reshape(-1, 2)
        return Moment(channel.kind, channel.newest, points, others, path)

    def _open(self, moment: Moment, details: Update, view: View) -> bytes | None:
        """Add the fields of the newest message to ``details`` and return its picture."""
        found = details_of(moment, view.cursor)
        if found is None:
            details["missing"] = "undecodable"
            with self._source.lock:
                if (channel := self._source.watch.channels.get(details["channel"])) is not None:
                    channel.note_undecodable(self._sent_details[0])
            return None
        details |= found
        try:
            return picture_of(moment, self._pictures)
        except GraphnavError as error:
            details["no_picture"] = str(error)
            return None

    def _track(self, watch: Watch) -> Update:
        """Return the robot's pose and what its path has got since the last update, nothing where nothing has."""
        track = watch.track
        generation, n_sent = self._sent_track
        if generation != track.generation:
            n_sent = 0
        now = (track.generation, len(track.points_m))
        if track.pose is None or (now == self._sent_track and self._sent_pose == track.pose):
            return {}
        self._sent_track, self._sent_pose = now, track.pose
        return {
            "track": {
                "channel": track.channel,
                "pose": track.pose,
                "moving": track.moving,
                "reset": n_sent == 0,
                "points": track.points_m[n_sent:],
            }
        }


def _stamp(channel: WatchedChannel) -> int | None:
    """Return the stamp of the newest message that is kept."""
    if channel.kind is None or channel.newest is None or len(channel.newest.data) < channel.kind.min_bytes:
        return None
    stamped = channel.kind.stamp(channel.newest.data)
    return None if stamped is None else stamped[0]
