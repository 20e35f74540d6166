"""Choose the LCM URL of a live run."""

from __future__ import annotations

from graphnav.graph import Graph
from graphnav.lcm_url import lcm_url


def live_url(graph: Graph, given: str | None, option: str = "--url") -> str:
    """Return the LCM URL of a live run: ``given``, the graph's, ``LCM_DEFAULT_URL``, or LCM's default group.

    ``option``: name of the given URL in errors.

    Raises
    ------
    UserError
        The URL does not reach other programs.
    """
    return lcm_url((option, given), ("run.url", graph.run.url))
