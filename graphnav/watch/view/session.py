"""Compose the updates of one page: only visible data, only the newest, only changes."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from typing import Any

from graphnav import About, GraphnavError
from graphnav.core.catalog import Catalog
from graphnav.core.pictures import Pictures
from graphnav.watch.feed import WatchedChannel
from graphnav.watch.fields.plain_values import plain
from graphnav.watch.view.content.details import Moment, details_of, moment_of, picture_of
from graphnav.watch.view.content.graph_layout import layout_of
from graphnav.watch.view.content.state import floor_map, newest_map, state_of
from graphnav.watch.view.page_feed import PageFeed, PageState
from graphnav.watch.view.robot_track import RobotTrack
from graphnav.watch.view.web.page_requests import View

_STATE_S = 0.5

Update = dict[str, Any]


@dataclass
class _Sent:
    """The data already sent to a page, to detect changes."""

    state_due_s: float = 0.0
    details: tuple[int, View] | None = None
    channel: str | None = None
    point: int = 0
    world: bytes | None = None
    track: tuple[str, int, int] = ("", -1, 0)
    pose: tuple[float, float, float] | None = None


class Session:
    """Gathers the updates of one page; one thread at a time calls it."""

    def __init__(self, feed: PageFeed, catalog: Catalog, pictures: Pictures) -> None:
        self.view = View()
        self._feed, self._catalog, self._pictures = feed, catalog, pictures
        self._state: PageState | None = None
        self._run_id: str | None = None
        self._sent = _Sent()
        self._sent_graph: tuple[str, tuple[str, ...]] | None = None

    def greeting(self) -> str:
        """Return the first message: a description of the feed."""
        log = self._feed.log
        hello = {"kind": "hello", "name": self._feed.name, "log": log is not None}
        return json.dumps(hello | ({"length_s": log.length_s} if log else {}), allow_nan=False)

    def update(self, number: int) -> tuple[str, bytes | None] | None:
        """Return update ``number`` and its picture, None if nothing has changed."""
        update: Update = {}
        view, about, moment, world, picture = self.view, None, None, None, None
        with self._feed.lock:
            state, watch = self._feed.state, self._feed.state.watch
            run_id = watch.announcements.shown(view.run_id, state.clock())
            if state is not self._state or run_id != self._run_id:
                self._state, self._run_id, self._sent = state, run_id, _Sent()
            if run_id is not None:
                about = watch.announcements.runs[run_id].about
            if (now_s := time.monotonic()) >= self._sent.state_due_s:
                self._sent.state_due_s = now_s + _STATE_S
                update["state"] = state_of(self._feed, run_id)
            if view.channel is not None:
                channel = watch.channels.get(view.channel)
                if (wanted := (channel.count if channel else 0, view)) != self._sent.details:
                    self._sent.details = wanted
                    update["details"] = self._head(view.channel, channel)
                    moment = self._moment(state, channel, run_id)
            if view.with_map:
                world = newest_map(state.channels_of(run_id).values())
                update |= self._track(state.track_of(run_id))
        if about is not None and (about.graph_yaml, about.channels) != self._sent_graph:
            update["graph"] = self._graph(about)
        if world is not None and world.data != self._sent.world:
            self._sent.world = world.data
            update["world"] = floor_map(world.data)
        if moment is not None:
            picture = self._open(moment, update["details"], view)
        if not update:
            return None
        head = {"kind": "update", "number": number, "has_picture": picture is not None}
        return json.dumps(plain(head | update), allow_nan=False), picture

    def _graph(self, about: About) -> Update:
        self._sent_graph = about.graph_yaml, about.channels
        try:
            return layout_of(about, self._catalog)
        except GraphnavError as error:
            return {"failure": str(error)}

    def _head(self, name: str, channel: WatchedChannel | None) -> Update:
        """Return the header of the open channel, and a keyword for the reason if it has no details."""
        missing = ""
        if channel is None or not channel.count:
            missing = "not_received"
        elif channel.is_too_large:
            missing = "too large"
        elif channel.kind is None:
            missing = "unknown type"
        is_new = self._sent.channel != name
        if is_new:
            self._sent.channel, self._sent.point = name, 0
        return {"channel": name, "missing": missing, "reset": is_new}

    def _moment(self, state: PageState, channel: WatchedChannel | None, run_id: str | None) -> Moment | None:
        """Return the current messages of the open channel."""
        if channel is None:
            return None
        after, self._sent.point = self._sent.point, channel.count
        return moment_of(state, channel, run_id, after)

    def _open(self, moment: Moment, details: Update, view: View) -> bytes | None:
        """Add the fields of the newest message to ``details`` and return its picture."""
        found = details_of(moment, view.cursor)
        if found is None:
            details["missing"] = "undecodable"
            with self._feed.lock:
                if (channel := self._feed.state.watch.channels.get(details["channel"])) is not None:
                    channel.note_undecodable(channel.count)
            return None
        details |= found
        try:
            return picture_of(moment, self._pictures)
        except GraphnavError as error:
            details["no_picture"] = str(error)
            return None

    def _track(self, track: RobotTrack) -> Update:
        """Return the robot's pose and the new points of its path, empty if unchanged."""
        sent = self._sent
        n_sent = sent.track[2] if sent.track[:2] == (track.channel, track.generation) else 0
        now = (track.channel, track.generation, len(track.points_m))
        if track.pose is None or (now == sent.track and track.pose == sent.pose):
            return {}
        sent.track, sent.pose = now, track.pose
        return {
            "track": {
                "channel": track.channel,
                "pose": track.pose,
                "moving": track.moving,
                "reset": n_sent == 0,
                "points": track.points_m[n_sent:],
            }
        }
