"""The outcome of a run, from its log."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graphnav import Map, State
from graphnav_view.track import Track


def outcome_text(graph: Mapping[str, Any], last: State, end_s: float) -> str:
    """Return the outcome of a run whose last state, at ``end_s``, is ``last``."""
    until_s = (graph.get("run") or {}).get("until_s")
    if last.contact:
        return f"Contact after {end_s:.1f} s"
    if last.at_goal:
        return f"Goal reached after {end_s:.1f} s"
    if until_s is not None and end_s >= 0.98 * float(until_s):
        return f"Time is up after {end_s:.1f} s"
    return f"Ended after {end_s:.1f} s"


def drive_texts(world: Map, track: Track) -> list[str]:
    """Return the length and clearance of a drive; the latter only in a world with bodies, after a metre."""
    shortest = f" (shortest {world.shortest_m:.2f} m)" if world.shortest_m > 0 else ""
    texts = [f"path {track.length_m:.2f} m{shortest}"]
    if len(world.vertices_m) and track.clearance_m is not None:
        texts.append(f"minimum clearance {track.clearance_m:.2f} m after the first metre")
    return texts
