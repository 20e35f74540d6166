"""Terms of the planar model's basis: the factor of each field, given the motion of a frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from graphnav import Motion
from graphnav.arrays import Doubles

Term = Literal["mean", "v", "w", "vv", "vw", "ww"]
"""Products of v (``forward_m``) and w (``turn_rad``); "mean" is the mean flow of driving straight and has no factor."""

MEAN = "mean"
COMPONENT = "c"
"""First letter of the terms "c1", "c2", ...: principal components, whose factors are free and fitted to each frame."""


def names_of_components(count: int) -> tuple[str, ...]:
    """Return the terms of so many principal components."""
    return tuple(f"{COMPONENT}{number}" for number in range(1, count + 1))


def driving_terms(terms: Sequence[str]) -> list[str]:
    """Return the terms that depend on the motion of a frame."""
    return [term for term in terms if term != MEAN and not term.startswith(COMPONENT)]


def free_terms(terms: Sequence[str]) -> list[str]:
    """Return the terms whose factors are free: the principal components."""
    return [term for term in terms if term.startswith(COMPONENT)]


def orders(terms: Sequence[str]) -> Doubles:
    """Return the powers of v and of w in each of these driving terms, (2, terms)."""
    return np.array([[term.count(letter) for term in terms] for letter in "vw"], np.float64)


def factors(terms: Sequence[str], motion: Motion) -> Doubles:
    """Return the factor of each of these driving terms for this motion, (terms,)."""
    v, w = orders(terms)
    return np.asarray(motion.forward_m**v * motion.turn_rad**w)
