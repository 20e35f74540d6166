"""How a run ended, as its log tells."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graphnav import State


def outcome_text(graph: Mapping[str, Any], last: State, end_s: float) -> str:
    """Return how a run ended whose last state, at ``end_s``, is ``last``."""
    until_s = (graph.get("run") or {}).get("until_s")
    if last.contact:
        return f"Contact after {end_s:.1f} s"
    if last.at_goal:
        return f"Goal reached after {end_s:.1f} s"
    if until_s is not None and end_s >= 0.98 * float(until_s):
        return f"Time is up after {end_s:.1f} s"
    return f"Ended after {end_s:.1f} s"
