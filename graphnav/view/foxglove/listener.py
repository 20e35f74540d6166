"""What clients ask for, noted by the threads of the SDK for the thread that serves; nothing is done there."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from graphnav.view.foxglove.log_player import LogPlayer
from graphnav.view.foxglove.playback import Playback, Request, Status

_STATUS = {Status.PLAYING: "Playing", Status.PAUSED: "Paused", Status.ENDED: "Ended"}


class Listener:
    """Implements the SDK's ``ServerListener`` as far as clients may ask for something.

    ``websocket``: the module ``foxglove.websocket``. ``wake``: called when there is something to do.
    """

    def __init__(self, websocket: Any, player: LogPlayer | None, wake: Callable[[], None]) -> None:
        self._websocket, self._player, self._wake = websocket, player, wake
        self._lock = threading.Lock()
        self._asked: set[str] = set()
        self.told: Playback | None = None

    def asked(self) -> set[str]:
        """Return the topics that clients have subscribed to since the last time."""
        with self._lock:
            asked, self._asked = self._asked, set()
            return asked

    def on_subscribe(self, _client: Any, channel: Any) -> None:
        """Note a topic; a log begins to play with the first one."""
        with self._lock:
            self._asked.add(channel.topic)
        if self._player is not None:
            self._player.begin()
        self._wake()

    def on_unsubscribe(self, _client: Any, _channel: Any) -> None:
        """Do nothing: whether a topic is wanted is asked with every message."""

    def on_playback_control_request(self, asked: Any) -> Any:
        """Play, pause, seek; returns the answer, which goes to all clients."""
        if self._player is None:
            return None
        seek_us = None if asked.seek_time is None else asked.seek_time // 1000 - self._player.begin_us
        is_play = asked.playback_command == self._websocket.PlaybackCommand.Play
        playback = self._player.obey(Request(is_play, asked.playback_speed, seek_us))
        self.told = playback
        self._wake()
        return self.state_of(playback, did_seek=seek_us is not None, request_id=asked.request_id)

    def state_of(self, playback: Playback, *, did_seek: bool = False, request_id: str | None = None) -> Any:
        """Return where a log is being played as the SDK tells it to clients."""
        assert self._player is not None
        return self._websocket.PlaybackState(
            status=getattr(self._websocket.PlaybackStatus, _STATUS[playback.status]),
            current_time=(self._player.begin_us + playback.at_us) * 1000,
            playback_speed=playback.speed_ratio,
            did_seek=did_seek,
            request_id=request_id,
        )
