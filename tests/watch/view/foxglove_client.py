"""A client of Foxglove's WebSocket protocol that knows nothing of the SDK, and a server for it in a thread."""

from __future__ import annotations

import base64
import json
import struct
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, NamedTuple, Self

import jsonschema
import pytest
from mcap.records import Schema
from mcap_protobuf.decoder import DecoderFactory
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from graphnav.core.catalog import Catalog
from graphnav.watch.feed import Feed
from graphnav.watch.view.foxglove import FoxgloveServer

PATIENCE_S = 30.0
_POLL_S = 0.05
_STATUS = ("playing", "paused", "buffering", "ended")


class Shown(NamedTuple):
    """A message that was received: the topic's schema, the time in nanoseconds, the message decoded by the schema."""

    topic: str
    schema: str
    time_ns: int
    message: Any


class State(NamedTuple):
    """Where the log is being played, as the server says."""

    status: str
    time_ns: int
    speed: float
    did_seek: bool
    request_id: str


class FoxgloveServed:
    """A feed that is being served by a thread."""

    def __init__(self, name: str) -> None:
        self._server = FoxgloveServer(Feed(name), Catalog())
        self._ready, self._ending = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()
        assert self._ready.wait(PATIENCE_S)

    def close(self) -> None:
        """End the server and what it serves."""
        self._ending.set()
        self._thread.join(PATIENCE_S)
        assert not self._thread.is_alive()

    def _serve(self) -> None:
        def ready(url: str, app_url: str) -> None:
            self.url, self.app_url = url, app_url
            self._ready.set()

        self._server.serve("127.0.0.1", 0, ready, self._ending)


class FoxgloveClient:
    """A client: what is on offer is in ``offered`` by topic, what was withdrawn is not."""

    def __init__(self, url: str, origin: str | None = None) -> None:
        self._open = ExitStack()
        self.socket = self._open.enter_context(
            connect(
                url,
                subprotocols=[Subprotocol("foxglove.sdk.v1")],
                origin=None if origin is None else Origin(origin),
                max_size=None,
                close_timeout=1,
                ping_interval=None,
            )
        )
        self.info = json.loads(self.socket.recv(PATIENCE_S))
        assert self.info["op"] == "serverInfo"
        self.offered: dict[str, dict[str, Any]] = {}
        self.state: State | None = None
        self.time_ns = 0
        self.shown: list[Shown] = []
        self._by_id: dict[int, dict[str, Any]] = {}
        self._decoders: dict[int, Callable[[bytes], Any]] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    def subscribe(self, *topics: str) -> None:
        """Subscribe to topics, once they are on offer."""
        self.until(lambda: set(topics) <= self.offered.keys())
        ids = [self.offered[topic]["id"] for topic in topics]
        said = {"op": "subscribe", "subscriptions": [{"id": one, "channelId": one} for one in ids]}
        self.socket.send(json.dumps(said))

    def unsubscribe(self, topic: str) -> None:
        """Want no more of a topic."""
        self.socket.send(json.dumps({"op": "unsubscribe", "subscriptionIds": [self.offered[topic]["id"]]}))

    def control(self, *, play: bool, speed: float = 1.0, seek_ns: int | None = None, request: str = "r") -> State:
        """Ask for playing, and return the answer."""
        head = struct.pack("<BBfBQI", 3, not play, speed, seek_ns is not None, seek_ns or 0, len(request))
        self.socket.send(head + request.encode())
        self.until(lambda: self.state is not None and self.state.request_id == request)
        assert self.state is not None
        return self.state

    def of(self, topic: str) -> list[Shown]:
        """Return what came on a topic so far."""
        return [shown for shown in self.shown if shown.topic == topic]

    def until(self, holds: Callable[[], Any], meanwhile: Callable[[], None] = lambda: None) -> None:
        """Take what the server says until something holds, and do something now and then; fail where it never does."""
        next_s = time.monotonic()
        end_s = next_s + PATIENCE_S
        while not holds():
            now_s = time.monotonic()
            left_s = end_s - now_s
            if left_s <= 0:
                raise AssertionError(f"never: {sorted(self.offered)}, {self.state}, {self.shown[-3:]}")
            if now_s >= next_s:
                meanwhile()
                next_s = now_s + _POLL_S
            try:
                self._take(self.socket.recv(min(left_s, _POLL_S)))
            except TimeoutError:
                continue

    def _take(self, data: str | bytes) -> None:
        if isinstance(data, str):
            self._take_text(json.loads(data, parse_constant=pytest.fail))
        elif data[0] == 1:
            number, time_ns = struct.unpack_from("<IQ", data, 1)
            channel = self._by_id[number]
            message = self._decoders[number](data[13:])
            self.shown.append(Shown(channel["topic"], channel["schemaName"], time_ns, message))
        elif data[0] == 2:
            (self.time_ns,) = struct.unpack_from("<Q", data, 1)
        elif data[0] == 5:
            status, time_ns, speed, did_seek, _ = struct.unpack_from("<BQfBI", data, 1)
            self.state = State(_STATUS[status], time_ns, speed, bool(did_seek), data[19:].decode())
        else:
            raise AssertionError(data)

    def _take_text(self, said: dict[str, Any]) -> None:
        if said["op"] == "advertise":
            for channel in said["channels"]:
                self.offered[channel["topic"]] = self._by_id[channel["id"]] = channel
                self._decoders[channel["id"]] = _decoder(channel)
        elif said["op"] == "unadvertise":
            for number in said["channelIds"]:
                gone = self._by_id[number]["topic"]
                if self.offered.get(gone, {}).get("id") == number:
                    del self.offered[gone]
        else:
            raise AssertionError(said)


def _decoder(channel: dict[str, Any]) -> Callable[[bytes], Any]:
    """Return a function that decodes a channel's messages only by its schema."""
    if channel["encoding"] == "json":
        assert channel["schemaEncoding"] == "jsonschema"
        schema = json.loads(channel["schema"])

        def checked(data: bytes) -> Any:
            message = json.loads(data, parse_constant=pytest.fail)
            jsonschema.validate(message, schema)
            return message

        return checked
    assert (channel["encoding"], channel["schemaEncoding"]) == ("protobuf", "protobuf")
    record = Schema(channel["id"], base64.b64decode(channel["schema"]), "protobuf", channel["schemaName"])
    decode = DecoderFactory().decoder_for("protobuf", record)
    assert decode is not None
    return decode
