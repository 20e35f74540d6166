"""The terms of the planar model's basis: what multiplies each field, given the motion of a frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from graphnav import Motion

Term = Literal["mean", "v", "w", "vv", "vw", "ww"]
"""Products of v (``forward_m``) and w (``turn_rad``); "mean" is the mean flow of driving straight and has no factor."""

MEAN = "mean"


def driving_terms(terms: Sequence[str]) -> list[str]:
    """Return the terms that the motion of a frame multiplies."""
    return [term for term in terms if term != MEAN]


def factors(terms: Sequence[str], motion: Motion) -> npt.NDArray[np.float64]:
    """Return what multiplies each of these driving terms for this motion, (terms,)."""
    v, w = motion.forward_m, motion.turn_rad
    return np.array([v ** term.count("v") * w ** term.count("w") for term in terms])
