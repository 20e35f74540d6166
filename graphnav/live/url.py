"""Which LCM URL a live run uses."""

from __future__ import annotations

import os

from graphnav.bus import GROUP, require_route, with_defaults
from graphnav.errors import BusError, Place, UserError
from graphnav.graph import Graph

_DEFAULT = "LCM_DEFAULT_URL"


def live_url(graph: Graph, given: str | None, option: str = "--url") -> str:
    """Return the LCM URL of a live run: what was given, the graph's, ``LCM_DEFAULT_URL``, or this machine's group.

    ``option``: what errors call the one that was given.

    Raises
    ------
    UserError
        No other program can be reached there.
    """
    choices = ((option, given), ("run.url", graph.run.url), (_DEFAULT, os.environ.get(_DEFAULT) or None))
    where, url = next(((where, url) for where, url in choices if url is not None), ("", GROUP))
    place = Place(where) if where else None
    if not url.startswith("udpm://"):
        hint = f"write {GROUP}, or another group of 239.0.0.0/8"
        raise UserError.of(f"'{url}' is not a udpm:// URL", hint, place)
    try:
        url = with_defaults(url)
        require_route(url)
    except BusError as error:
        what, _, hint = str(error).partition("\n")
        raise UserError.of(what, hint.strip(), place) from error
    return url
