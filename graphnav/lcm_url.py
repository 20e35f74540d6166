"""Which LCM URL to use: the one given, that of the environment, or this machine's group."""

from __future__ import annotations

import os
from urllib.parse import parse_qsl, urlencode, urlsplit

from graphnav.bus import GROUP, require_route, with_defaults
from graphnav.errors import BusError, Place, UserError

DEFAULT_URL = "LCM_DEFAULT_URL"
"""The environment variable by which every program of LCM is told its URL."""


def lcm_url(*choices: tuple[str, str | None]) -> str:
    """Return the first URL that is given, else that of ``LCM_DEFAULT_URL``, else this machine's group.

    ``choices``: what errors call a URL, and the URL, None if it is not given.

    Raises
    ------
    UserError
        No other program can be reached there.
    """
    return with_defaults(_chosen(choices))


def tap_url() -> str:
    """Return the URL where runs are tapped: as `lcm_url`, but what is sent there does not leave this machine.

    Raises
    ------
    UserError
        No other program can be reached there.
    """
    url = _chosen(())
    options = dict(parse_qsl(urlsplit(url).query)) | {"ttl": "0"}
    return f"udpm://{urlsplit(with_defaults(url)).netloc}?{urlencode(options)}"


def _chosen(choices: tuple[tuple[str, str | None], ...]) -> str:
    """Return the URL as it was written, after it was checked."""
    default = DEFAULT_URL, os.environ.get(DEFAULT_URL) or None
    where, url = next(((where, url) for where, url in (*choices, default) if url is not None), ("", GROUP))
    place = Place(where) if where else None
    if not url.startswith("udpm://"):
        raise UserError.of(f"'{url}' is not a udpm:// URL", f"write {GROUP}, or another group of 239.0.0.0/8", place)
    try:
        require_route(with_defaults(url))
    except BusError as error:
        what, _, hint = str(error).partition("\n")
        raise UserError.of(what, hint.strip(), place) from error
    return url
