"""The files of the page and their HTTP headers."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from typing import NamedTuple

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
