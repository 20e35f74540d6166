"""Overrides of which later ones replace some stages."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from graphnav.graph import Override, Target


def without_replaced(overrides: Iterable[Override], later: Iterable[Override]) -> tuple[Override, ...]:
    """Return overrides without their swaps of stages that later ones swap, too."""
    swapped = {stage for override in later if override.target.kind == "stage" for stage in override.target.stages}
    kept = []
    for override in overrides:
        stages = override.target.stages
        if override.target.kind == "stage" and swapped.intersection(stages):
            stages = tuple(stage for stage in stages if stage not in swapped)
            if stages:
                kept.append(replace(override, target=Target("stage", stages)))
        else:
            kept.append(override)
    return tuple(kept)
