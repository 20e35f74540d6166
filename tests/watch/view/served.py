"""The server of the page in a thread, and a page without a browser."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, Self

from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

from graphnav.core.catalog import Catalog
from graphnav.watch.view import PageFeed, PageServer

PATIENCE_S = 30.0


class Served:
    """A page that is being served by a thread."""

    def __init__(self, source: PageFeed) -> None:
        self.source = source
        self._ready = threading.Event()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()
        assert self._ready.wait(PATIENCE_S)

    @property
    def port(self) -> int:
        """The port of the page."""
        return int(self.url.rpartition(":")[2].strip("/"))

    def end(self) -> None:
        """End the server."""
        if not self._task.done():
            self._loop.call_soon_threadsafe(self._task.cancel)
        self._thread.join(PATIENCE_S)

    def close(self) -> None:
        """End the server and what it serves."""
        self.end()
        self.source.close()

    def _serve(self) -> None:
        asyncio.set_event_loop(self._loop)

        def ready(url: str) -> None:
            self.url = url
            self._ready.set()

        self.source.start()
        self._task = self._loop.create_task(PageServer(self.source, Catalog()).serve("127.0.0.1", 0, ready))
        try:
            self._loop.run_until_complete(self._task)
        except asyncio.CancelledError:
            self._loop.run_until_complete(self._loop.shutdown_default_executor())
        finally:
            self._loop.close()


class Page:
    """A page without a browser: it draws nothing, but says that it did."""

    def __init__(self, served: Served, **headers: str) -> None:
        origin = served.url.rstrip("/")
        self._open = ExitStack()
        address = f"ws://127.0.0.1:{served.port}/updates"
        link = connect(address, origin=Origin(headers.pop("origin", origin)), additional_headers=headers)
        self.socket: ClientConnection = self._open.enter_context(link)
        self.known: dict[str, Any] = json.loads(self.socket.recv(PATIENCE_S))
        self.picture: bytes | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave."""
        self._open.close()

    def say(self, **order: Any) -> None:
        """Send an order."""
        self.socket.send(json.dumps(order))

    def update(self) -> dict[str, Any]:
        """Return the next update, after saying that it is drawn."""
        update: dict[str, Any] = json.loads(self.socket.recv(PATIENCE_S))
        if update["has_picture"]:
            picture = self.socket.recv(PATIENCE_S)
            assert isinstance(picture, bytes)
            self.picture = picture
        self.say(kind="shown", number=update["number"])
        self.known |= update
        return update

    def until(self, holds: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """Return all that is known, once something holds; fail where it never does."""
        for _ in range(150):
            self.update()
            if holds(self.known):
                return self.known
        raise AssertionError(f"never: {self.known}")

    def channel(self, name: str) -> dict[str, Any]:
        """Return what is known of a channel."""
        return next((c for c in self.known.get("state", {}).get("channels", []) if c["name"] == name), {})
