"""The doors of a wall: its line, cut where they are."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles

Gap = tuple[float, float]
"""Where an opening begins and ends, in metres along the line."""


def length_m(points: Doubles) -> float:
    """Return the length of a line, (n, 2)."""
    return float(_distances(points)[-1])


def cut(points: Doubles, gaps: list[Gap]) -> list[Doubles]:
    """Return the parts of a line, each (n, 2), that lie outside all gaps, in order; the line is open."""
    begins = [0.0, *(end for _, end in sorted(gaps))]
    ends = [*(begin for begin, _ in sorted(gaps)), length_m(points)]
    begins = list(np.maximum.accumulate(begins))  # gaps may overlap
    return [_part(points, begin, end) for begin, end in zip(begins, ends, strict=True) if end - begin > 1e-6]


def _part(points: Doubles, begin_m: float, end_m: float) -> Doubles:
    at_m = _distances(points)
    within = at_m[(at_m > begin_m + 1e-9) & (at_m < end_m - 1e-9)]
    where = np.concatenate([[begin_m], within, [end_m]])
    return np.stack([np.interp(where, at_m, points[:, axis]) for axis in (0, 1)], axis=1)


def _distances(points: Doubles) -> Doubles:
    """Return how far along the line each point is, (n,)."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    distances: Doubles = np.concatenate([[0.0], np.cumsum(steps)])
    return distances
