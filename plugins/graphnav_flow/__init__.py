"""Stages of the family ``flow``: dense optical flow, by several methods and from the truth."""

from __future__ import annotations

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages; their modules are imported only now."""
    from graphnav_flow.dis import Dis
    from graphnav_flow.farneback import Farneback
    from graphnav_flow.lucas_kanade import LucasKanade
    from graphnav_flow.plain_lucas_kanade import PlainLucasKanade
    from graphnav_flow.truth import Truth

    return [LucasKanade, PlainLucasKanade, Dis, Farneback, Truth]
