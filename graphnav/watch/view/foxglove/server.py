"""Serve Foxglove's WebSocket protocol with Foxglove's SDK."""

from __future__ import annotations

import logging
import socket
import threading
import time
from collections.abc import Callable
from typing import Any

from graphnav import UserError
from graphnav.core.catalog import Catalog
from graphnav.watch.export.entries.event_lines import outcome_lines
from graphnav.watch.export.extras import require
from graphnav.watch.export.foxglove import FoxgloveChannels
from graphnav.watch.feed import Feed, LiveFeed, LogFeed
from graphnav.watch.view.foxglove.arrivals import Arrivals
from graphnav.watch.view.foxglove.converter import Converter
from graphnav.watch.view.foxglove.losses import Reason
from graphnav.watch.view.foxglove.playback import Playback, Player, Request, Status
from graphnav.watch.view.web.hosts import bracketed

_STATUS = {Status.PLAYING: "Playing", Status.PAUSED: "Paused", Status.ENDED: "Ended"}
_WAIT_S = 0.05
_COUNT_S = 1.0
_THREAD = "graphnav-foxglove"
_BACKLOG = 512
"""The queue length for a slow client; beyond it the oldest messages are dropped."""


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


class FoxgloveServer:
    """Serves one feed to Foxglove, or to any other client of the protocol ``foxglove.sdk.v1``.

    Raises UserError if the SDK is not installed, LogError if a log cannot be read, GraphnavError if it is empty.
    """

    def __init__(self, feed: Feed, catalog: Catalog) -> None:
        self._foxglove = require("foxglove", "'--foxglove'")
        self._websocket = require("foxglove.websocket", "'--foxglove'")
        self._catalog = catalog
        self._arrivals = arrivals = Arrivals()
        self._feed: LiveFeed | LogFeed
        self._player: Player | None = None
        if feed.is_live:
            self._feed = LiveFeed(feed, arrivals.put, arrivals.wake, _THREAD)
            arrivals.epoch_us = round(feed.epoch_s * 1e6)
        else:
            self._feed = LogFeed(feed, arrivals.put, arrivals.jump, name=_THREAD)
            self._player = Player(self._feed)
            arrivals.epoch_us = self._player.begin_us
        self._n_dropped = 0
        log = logging.getLogger("foxglove")
        log.addHandler(logging.NullHandler())
        log.propagate = False

    def serve(self, host: str, port: int, ready: Callable[[str, str], None], ending: threading.Event) -> None:
        """Serve until ``ending`` is set.

        ``ready`` is called with the address to connect to, and that of Foxglove's web app connected to it.

        Raises
        ------
        OSError
            It cannot listen there.
        UserError
            The SDK fails for another reason.
        """
        context = self._foxglove.Context()
        converter = Converter(FoxgloveChannels(context), self._catalog, self._feed.name)
        if self._player is not None:
            _prepare(converter, self._player)
        listener = Listener(self._websocket, self._player, self._arrivals.wake)
        _probe(host, port)
        server = self._start(host, port, context, listener)
        self._feed.start()
        try:
            ready(f"ws://{bracketed(host)}:{server.port}", server.app_url() or "")
            self._loop(server, converter, listener, ending)
        finally:
            server.stop()
            self._feed.close()

    def _start(self, host: str, port: int, context: Any, listener: Listener) -> Any:
        is_log = {}
        if (player := self._player) is not None:
            ends = (player.begin_us * 1000, (player.begin_us + player.duration_us) * 1000)
            is_log = {"capabilities": [self._websocket.Capability.Time], "playback_time_range": ends}
        try:
            return self._foxglove.start_server(
                name=f"graphnav {self._feed.name}",
                host=host,
                port=port,
                server_listener=listener,
                context=context,
                message_backlog_size=_BACKLOG,
                **is_log,
            )
        except RuntimeError as error:
            raise UserError.of(f"cannot listen on {host}, port {port}: {error}", "choose another --port") from error

    def _loop(self, server: Any, converter: Converter, listener: Listener, ending: threading.Event) -> None:
        failure = ""
        sent = self._player.state if self._player is not None else None
        count_due_s = time.monotonic()
        while not ending.is_set():
            if (now_s := time.monotonic()) >= count_due_s:
                count_due_s = now_s + _COUNT_S
                before, self._n_dropped = self._n_dropped, self._feed.dropped_packets()
                if self._n_dropped > before:
                    converter.losses.add(Reason.DROPPED, n=self._n_dropped - before)
            batch = self._arrivals.take(_WAIT_S)
            converter.show(batch)
            if topics := listener.new_topics():
                converter.show_again(topics)
            if sent is not None:
                sent = self._tell_playback(server, converter, listener, sent)
            if self._feed.failure not in {failure, ""}:
                failure = " ".join(self._feed.failure.split())
                converter.losses.add(Reason.FEED, why=failure)

    def _tell_playback(self, server: Any, converter: Converter, listener: Listener, sent: Playback) -> Playback:
        """Send clients the time of the log, and its playback state if that has changed."""
        player = self._player
        assert player is not None
        now = player.state
        server.broadcast_time((player.begin_us + now.at_us) * 1000)
        answered, listener.sent = listener.sent, None
        sent = answered or sent
        if (now.status, now.speed_ratio) != (sent.status, sent.speed_ratio):
            server.broadcast_playback_state(listener.state_of(now, did_seek=now.jump != sent.jump))
        if now.status is Status.ENDED and sent.status is not Status.ENDED:
            converter.tell(outcome_lines(player.recording, player.begin_us, player.begin_us + player.duration_us))
        return now


def _prepare(converter: Converter, player: Player) -> None:
    """Offer the channels of a log before it is played, and report its damage."""
    for name, lcm_class in player.recording.channels.items():
        if lcm_class is not None:
            converter.channels.offer(name, lcm_class, player.begin_us)
    if notice := player.recording.damage_notice():
        converter.losses.add(Reason.FEED, why=notice)


def _probe(host: str, port: int) -> None:
    """Raise OSError, with its number, if the address cannot be bound: the SDK gives only a string."""
    family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    with socket.socket(family, kind, protocol) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind(address)
        probe.listen()
