"""Record the requests of clients, in threads of the SDK, for the server's thread."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from graphnav.watch.view.foxglove.playback import Playback, Player, Request, Status

_STATUS = {Status.PLAYING: "Playing", Status.PAUSED: "Paused", Status.ENDED: "Ended"}


class Listener:
    """Implements the SDK's ``ServerListener`` for subscriptions and playback control.

    ``websocket``: the module ``foxglove.websocket``. ``wake``: called on each request.
    """

    def __init__(self, websocket: Any, player: Player | None, wake: Callable[[], None]) -> None:
        self._websocket, self._player, self._wake = websocket, player, wake
        self._lock = threading.Lock()
        self._new_topics: set[str] = set()
        self.sent: Playback | None = None

    def new_topics(self) -> set[str]:
        """Return the topics subscribed since the last call."""
        with self._lock:
            topics, self._new_topics = self._new_topics, set()
            return topics

    def on_subscribe(self, _client: Any, channel: Any) -> None:
        """Record a topic; a log starts playing with the first one."""
        with self._lock:
            self._new_topics.add(channel.topic)
        if self._player is not None:
            self._player.begin()
        self._wake()

    def on_unsubscribe(self, _client: Any, _channel: Any) -> None:
        """Do nothing: subscriptions are checked for every message."""

    def on_playback_control_request(self, request: Any) -> Any:
        """Play, pause, seek; return the new state, which is sent to all clients."""
        if self._player is None:
            return None
        seek_us = None if request.seek_time is None else request.seek_time // 1000 - self._player.begin_us
        is_play = request.playback_command == self._websocket.PlaybackCommand.Play
        playback = self._player.apply(Request(is_play, request.playback_speed, seek_us))
        self.sent = playback
        self._wake()
        return self.state_of(playback, did_seek=seek_us is not None, request_id=request.request_id)

    def state_of(self, playback: Playback, *, did_seek: bool = False, request_id: str | None = None) -> Any:
        """Return the playback state as a message of the SDK."""
        assert self._player is not None
        return self._websocket.PlaybackState(
            status=getattr(self._websocket.PlaybackStatus, _STATUS[playback.status]),
            current_time=(self._player.begin_us + playback.at_us) * 1000,
            playback_speed=playback.speed_ratio,
            did_seek=did_seek,
            request_id=request_id,
        )
