"""Draw the numbers of a map from a seed."""

from __future__ import annotations

import zlib

import numpy as np

from graphnav import Place, Problem, Range, Suggestion
from graphnav_world.maps.effort import Effort
from graphnav_world.maps.shape_keys import Point, Size

MAX_POINTS = 8000
"""Of all arcs of a map, whose chords leave the circle by at most 2 mm."""
_UNNAMED = {("pillars", 1, "field"), ("walls", 4, "arc")}
"""Keys that are not in the names of draws: the root, how deep, the key. Worlds depend on these names."""


class Draws:
    """Draws numbers from their ranges and collects problems.

    ``problems`` are those of any draw, ``misfits`` those of this one: where numbers are drawn, others may do.

    Each place in the map has a generator of its own, made from the seed, the attempt and the place, so that a change in
    one place leaves the others as they are. Where one generator draws many numbers, as those of zigzags and pillars do
    for all their angles, lengths, radii and places, how many it drew before decides what it draws next: another count
    of corners or pillars is another zigzag or field.

    ``effort`` is what all draws of this seed may take together. ``run_seed`` numbers worlds that are not drawn; it is
    the ``seed`` itself where none is given.
    """

    def __init__(self, seed: int, attempt: int, effort: Effort, run_seed: int | None = None) -> None:
        self.effort = effort
        self.run_seed = seed if run_seed is None else run_seed
        self.problems: list[Problem] = []
        self.misfits: list[Problem] = []
        self.drew = False
        self._n_points = 0
        self._seed, self._attempt = seed, attempt

    def rng(self, *path: str) -> np.random.Generator:
        """Return the generator of one place of the map."""
        self.drew = True
        name = ".".join(part for depth, part in enumerate(path) if (path[0], depth, part) not in _UNNAMED)
        return np.random.default_rng([self._seed, self._attempt, zlib.crc32(name.encode())])

    def number(self, wanted: Range[float]) -> float:
        """Return a number, drawn if it is a range."""
        low, high = wanted.low, wanted.high
        return low if low == high else self.rng(*wanted.path).uniform(low, high)

    def count(self, wanted: Range[int]) -> int:
        """Return an integer, drawn if it is a range; both ends may be drawn."""
        low, high = wanted.low, wanted.high
        return low if low == high else int(self.rng(*wanted.path).integers(low, high + 1))

    def pair(self, wanted: Point | Size) -> tuple[float, float]:
        """Return two numbers, each drawn if it is a range."""
        return self.number(wanted.x), self.number(wanted.y)

    def may_add(self, n_points: int, place: Place | None) -> bool:
        """Count the points of an arc; return whether the map may have them, else add a problem."""
        had, self._n_points = self._n_points, self._n_points + n_points
        if had <= MAX_POINTS < self._n_points:
            what = f"the arcs up to this one have {self._n_points} points, but those of a map may have {MAX_POINTS}"
            self.wrong(place, what, "leave some out, or give smaller radii or angles")
        return not self.is_full

    @property
    def is_full(self) -> bool:
        """Whether the arcs have more points than a map may have."""
        return self._n_points > MAX_POINTS

    def wrong(self, place: Place | None, what: str, hint: str | Suggestion = "") -> None:
        """Add a problem."""
        self.problems.append(Problem(place, what, hint))

    def unfit(self, place: Place | None, what: str, hint: str) -> None:
        """Add a problem of the numbers that were drawn."""
        self.misfits.append(Problem(place, what, hint))
