"""Serve the page: files over HTTP, updates over a WebSocket of the same origin."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from http import HTTPStatus
from importlib.resources import files
from typing import Any, NamedTuple, TypeVar

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

from graphnav.core.catalog import Catalog
from graphnav.core.pictures import Pictures
from graphnav.watch.feed import LogFeed
from graphnav.watch.view.page_feed import PageFeed
from graphnav.watch.view.session import Session
from graphnav.watch.view.web.hosts import Hosts, url_of
from graphnav.watch.view.web.page_requests import LogCommand, RequestError, Shown, View, parse_request

_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
}
_INDEX = "index.html"
SECURITY_HEADERS = {
    "Content-Security-Policy": "default-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""Restricts loading, sending and framing to this server's pages; LCM data cannot become a script."""
T = TypeVar("T")
_UPDATES = "/updates"
_SPEEDS = (0.25, 0.5, 1.0, 2.0, 5.0)
_MAX_PAGES = 8
_MAX_REQUEST_BYTES = 4096
_UPDATE_S = 0.2
_CLOSE_S = 1.0
"""The maximum wait for a hanging browser at shutdown."""


class PageFile(NamedTuple):
    """A file and its content type."""

    content_type: str
    body: bytes


def page_files() -> Mapping[str, PageFile]:
    """Return every file of the page by its route; the only other route is that of the updates."""
    found = {}
    for file in files("graphnav.watch.view.web").joinpath("page").iterdir():
        content_type = _TYPES.get(file.name[file.name.rfind(".") :])
        if content_type is not None:
            route = "/" if file.name == _INDEX else f"/{file.name}"
            found[route] = PageFile(content_type, file.read_bytes())
    return found


class PageServer:
    """Serves the page of one feed to up to 8 browsers.

    Each page gets at most 5 updates per second, and the next one only after it has drawn the last, so that a slow
    browser delays only itself. One thread makes all updates.
    """

    def __init__(self, feed: PageFeed, catalog: Catalog) -> None:
        self._feed, self._catalog, self._pictures = feed, catalog, Pictures(catalog)
        self._files = page_files()
        self._worker = ThreadPoolExecutor(1, "graphnav-view-update")
        self._hosts: Hosts | None = None
        self._n_pages = 0
        self._log = logging.getLogger("graphnav.watch.view")
        self._log.addHandler(logging.NullHandler())
        self._log.propagate = False

    async def serve(self, host: str, port: int, ready: Callable[[str], None]) -> None:
        """Serve until cancelled; ``ready`` is called with the page's address. Raises OSError if it cannot listen."""
        async with serve(
            self._page,
            host,
            port,
            process_request=self._answer,
            compression=None,
            max_size=_MAX_REQUEST_BYTES,
            max_queue=4,
            close_timeout=_CLOSE_S,
            server_header=None,
            logger=self._log,
        ) as server:
            bound_port = server.sockets[0].getsockname()[1]
            self._hosts = Hosts(host, bound_port)
            ready(url_of(host, bound_port))
            await server.serve_forever()

    def _answer(self, _connection: ServerConnection, request: Request) -> Response | None:
        """Return the response to a request, None for one that may become the WebSocket of a page."""
        hosts = request.headers.get_all("Host")
        if self._hosts is None or not self._hosts.admits(hosts):
            return _response(HTTPStatus.FORBIDDEN)
        if request.path == _UPDATES:
            if not self._hosts.admits_origin(request.headers.get_all("Origin"), hosts[0]):
                return _response(HTTPStatus.FORBIDDEN)
            return _response(HTTPStatus.SERVICE_UNAVAILABLE) if self._n_pages >= _MAX_PAGES else None
        file = self._files.get(request.path)
        return _response(HTTPStatus.NOT_FOUND) if file is None else _response(HTTPStatus.OK, *file)

    async def _page(self, connection: ServerConnection) -> None:
        """Serve one page until it disconnects or sends an invalid request."""
        self._n_pages += 1
        page = _Page(Session(self._feed, self._catalog, self._pictures))
        try:
            async with asyncio.TaskGroup() as both:
                both.create_task(self._send(connection, page))
                both.create_task(self._receive(connection, page))
        except* ConnectionClosed:
            pass
        finally:
            self._n_pages -= 1

    async def _send(self, connection: ServerConnection, page: _Page) -> None:
        """Send an update whenever the page has drawn the last one and data have changed."""
        await connection.send(page.session.greeting())
        number = 0
        while True:
            if page.drawn == number and (update := await self._work(page.session.update, number + 1)) is not None:
                number += 1
                text, picture = update
                await connection.send(text)
                if picture is not None:
                    await connection.send(picture)
            await asyncio.sleep(_UPDATE_S)

    async def _receive(self, connection: ServerConnection, page: _Page) -> None:
        """Handle the page's requests; raises an exception when the connection ends."""
        while True:
            try:
                command = parse_request(await connection.recv())
            except RequestError:
                await connection.close(CloseCode.POLICY_VIOLATION)
                continue
            if isinstance(command, View):
                page.session.view = command
            elif isinstance(command, Shown):
                page.drawn = command.number
            elif self._feed.log is not None:
                await self._work(_apply, self._feed.log, command, page.session.view.channel)

    async def _work(self, function: Callable[..., T], *arguments: Any) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._worker, function, *arguments)


@dataclass
class _Page:
    """An open page: its session, and the number of the last drawn update."""

    session: Session
    drawn: int = 0


def _apply(log: LogFeed, command: LogCommand, channel: str | None) -> None:
    """Apply a page's playback command; steps follow the open channel."""
    match command.action:
        case "play":
            log.play()
        case "pause":
            log.pause()
        case "seek":
            log.seek(command.value)
        case "step":
            log.step(1 if command.value > 0 else -1, channel)
        case "speed" if command.value in _SPEEDS:
            log.set_speed(command.value)


def _response(
    status: HTTPStatus, content_type: str = "text/plain; charset=utf-8", body: bytes | None = None
) -> Response:
    if body is None:
        body = f"{status.value} {status.phrase}\n".encode()
    headers = Headers(SECURITY_HEADERS)
    headers["Connection"] = "close"
    headers["Content-Length"] = str(len(body))
    headers["Content-Type"] = content_type
    return Response(status.value, status.phrase, headers, body)
