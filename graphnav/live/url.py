"""Which LCM URL a live run uses."""

from __future__ import annotations

from graphnav.graph import Graph
from graphnav.lcm_url import lcm_url


def live_url(graph: Graph, given: str | None, option: str = "--url") -> str:
    """Return the LCM URL of a live run: what was given, the graph's, ``LCM_DEFAULT_URL``, or this machine's group.

    ``option``: what errors call the one that was given.

    Raises
    ------
    UserError
        No other program can be reached there.
    """
    return lcm_url((option, given), ("run.url", graph.run.url))
