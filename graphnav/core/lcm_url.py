"""Choose the LCM URL: the given one, that of the environment, or this machine's group."""

from __future__ import annotations

import os
from urllib.parse import parse_qsl, urlencode, urlsplit

from graphnav.core.bus import Bus
from graphnav.core.errors import BusError, Place, UserError
from graphnav.core.graph import Graph

DEFAULT_URL = "LCM_DEFAULT_URL"
"""The environment variable that sets the URL for all LCM programs."""


def lcm_url(*choices: tuple[str, str | None]) -> str:
    """Return the first given URL, else that of ``LCM_DEFAULT_URL``, else this machine's group.

    ``choices``: the name of a URL in errors, and the URL, None if not given.

    Raises
    ------
    UserError
        The URL cannot reach other programs.
    """
    return Bus.with_defaults(_chosen(choices))


def live_url(graph: Graph, given: str | None, option: str = "--url") -> str:
    """Return the LCM URL of a live run: ``given``, the graph's, ``LCM_DEFAULT_URL``, or LCM's default group.

    ``option``: name of the given URL in errors.

    Raises
    ------
    UserError
        The URL does not reach other programs.
    """
    return lcm_url((option, given), ("run.url", graph.run.url))


def tap_url() -> str:
    """Return the URL of the tap: as `lcm_url`, but its messages do not leave this machine.

    Raises
    ------
    UserError
        The URL cannot reach other programs.
    """
    url = _chosen(())
    options = dict(parse_qsl(urlsplit(url).query)) | {"ttl": "0"}
    return f"udpm://{urlsplit(Bus.with_defaults(url)).netloc}?{urlencode(options)}"


def _chosen(choices: tuple[tuple[str, str | None], ...]) -> str:
    """Return the URL as written, after checking it."""
    default = DEFAULT_URL, os.environ.get(DEFAULT_URL) or None
    where, url = next(((where, url) for where, url in (*choices, default) if url is not None), ("", Bus.GROUP))
    place = Place(where) if where else None
    if not url.startswith("udpm://"):
        raise UserError.of(
            f"'{url}' is not a udpm:// URL", f"write {Bus.GROUP}, or another group of 239.0.0.0/8", place
        )
    try:
        Bus.require_route(Bus.with_defaults(url))
    except BusError as error:
        raise UserError.of(error.what, error.hint, place) from error
    return url
