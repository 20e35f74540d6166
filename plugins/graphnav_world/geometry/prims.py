"""The constants of a world's prims: where they are, and which of them move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graphnav.arrays import Doubles, Ints


@dataclass(frozen=True)
class Prims:
    """Bounding spheres of convex quads: ``center``, float64 (3, prims), and ``radius_m``, (prims,).

    ``edges``: the lines of their edges in Pluecker coordinates, direction and moment, float64 (6, 4, prims); an edge
    without length has the line of the one before. ``of_moving``: the prims of each moving body.
    """

    center: Doubles
    radius_m: Doubles
    edges: Doubles
    of_moving: tuple[slice, ...]

    @classmethod
    def of(cls, quads: Doubles, body: Ints, moving: Sequence[int]) -> Prims:
        """Return the constants of quads, float64 (prims, 4, 3), of these bodies, ascending (prims,)."""
        center = quads.mean(axis=1)
        radius = np.linalg.norm(quads - center[:, None], axis=2).max(axis=1, initial=0.0)
        return cls(np.ascontiguousarray(center.T), radius, _edges_of(quads), slices_of(body, moving))


def _edges_of(quads: Doubles) -> Doubles:
    after = np.roll(quads, -1, axis=1)
    lines = np.concatenate([after - quads, np.cross(after, quads)], axis=2)
    has_no_length = (after == quads).all(axis=2)
    lines[has_no_length] = np.roll(lines, 1, axis=1)[has_no_length]
    return np.ascontiguousarray(lines.T)


def slices_of(body: Ints, bodies: Sequence[int]) -> tuple[slice, ...]:
    """Return what belongs to each of these bodies; ``body``: ascending."""
    return tuple(slice(*np.searchsorted(body, (one, one + 1)).tolist()) for one in bodies)
