"""Hints that follow from the messages of a run: motions that were not driven, and why a model is missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from graphnav.live.teaching.taught import Taught

MIN_SPEED_MPS = 0.02
"""A slower robot stands."""
MIN_SPAN_MPS = 0.05
MIN_TURN_RADPS = 0.1
"""A slower turn counts as driving straight on."""


def gaps(taught: Taught) -> list[str]:
    """Return the motions that were not driven, a sentence each."""
    rates = taught.rates
    if not taught.needs_motion or not len(rates):
        return []
    speeds, turns = rates.T
    if abs(rates).max() < MIN_SPEED_MPS:
        return ["the robot stood still"]
    missing = []
    if speeds.max() < MIN_SPEED_MPS:
        missing.append("the robot never drove forward")
    elif speeds.max() - speeds.min() < MIN_SPAN_MPS:
        missing.append(f"the speed did not vary: {speeds.min():.2f} to {speeds.max():.2f} m/s")
    sides = [name for name, max_radps in (("left", turns.max()), ("right", -turns.min())) if max_radps < MIN_TURN_RADPS]
    if len(sides) == 2:
        missing.append("no turn was driven")
    elif sides:
        missing.append(f"no turn to the {sides[0]} was driven")
    return missing


def why_no_model(taught: Taught, inputs: Sequence[Mapping[str, Any]]) -> str:
    """Return the hint for a run without a model; ``inputs``: of a live run, their status at its end."""
    for one in inputs:
        if not one["accepted"]:
            rejected = zip(one["reasons"], one["rejected"], one["details"], strict=True)
            counts = [
                f"{count} {reason}{' (' * bool(told)}{told}{')' * bool(told)}" for reason, count, told in rejected
            ]
            if counts:
                return f"no message on {one['channel']} could be used: {', '.join(counts)}; correct its sender"
            return f"no message on {one['channel']}: start its sender, or give its URL with --url"
    if not taught.flows:
        return "no flow was computed: it needs two pictures or more; run it longer with --until"
    if taught.needs_motion and not len(taught.rates):
        return "no motion of a frame is known: give odometry whose stamps cover those of the pictures"
    missing = gaps(taught)
    if missing:
        return f"{'; '.join(missing)}; teach for longer, at several speeds, turning to both sides"
    return (
        f"{taught.flows} frames did not determine it: teach for longer, at several speeds, turning to both sides; "
        "the term mean also needs frames straight on, within the teacher's straight_forward_m"
    )
