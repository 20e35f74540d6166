"""The independent components of a frame in pixels, their lengths in order, and which cells are truly obstacle."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from graphnav import Components, Plane, Truth, block_mean
from graphnav.arrays import Bools, Doubles
from graphnav_view.panels.camera_panels import Field

Values = npt.NDArray[np.floating[Any]]
NAMES = ("v$_α$", "v$_β$")
_MIN_SHARE = 0.5
"""Of its pixels, above which a cell is ground or obstacle."""


def component_px(components: Components, which: int) -> Field:
    """Return v_alpha (0) or v_beta (1) in pixels, as the score is: divided by its greater unmixing coefficient.

    So the greater of the coefficients by which flow and planar flow add up to it is 1. Its sign, which a separation
    leaves open, is that with which it is part of the flow.
    """
    greater = float(np.abs(np.linalg.inv(components.mixing)[which]).max())
    scale = math.copysign(greater, components.mixing[0, which])
    field = (components.alpha, components.beta)[which]
    return Field(field / np.float32(scale), components.valid, components.step_px)


class Kinds(NamedTuple):
    """Which cells (rows, cols) are truly ground and obstacle: most of their pixels are. Some are neither."""

    ground: Bools
    obstacle: Bools

    def obstacle_ratio(self, valid: npt.NDArray[Any]) -> float | None:
        """Return the share of obstacle among the valid cells of both kinds; None if there are none."""
        ground, obstacle = (int(np.count_nonzero(kind & (valid != 0))) for kind in self)
        return obstacle / (ground + obstacle) if ground + obstacle else None


def kinds_of(truth: Truth | None, grid: Components | Plane) -> Kinds:
    """Return the true kinds of the cells of a grid; all are neither without a truth that fits."""
    shape = grid.valid.shape
    nothing = np.zeros(shape, np.bool_)
    factor, rest = (0, 1) if truth is None else divmod(grid.step_px, truth.step_px)
    if truth is None or rest or not factor:
        return Kinds(nothing, nothing)
    is_obstacle = truth.obstacle != 0
    is_ground = ~is_obstacle & np.isfinite(truth.depth_m)
    ground, obstacle = (block_mean(kind.astype(np.float32), factor) > _MIN_SHARE for kind in (is_ground, is_obstacle))
    return Kinds(ground, obstacle) if ground.shape == shape else Kinds(nothing, nothing)


class Norms(NamedTuple):
    """The lengths of a component's vectors, ascending, their median m [OI, eq. 3], and the kind of each; px, (n,)."""

    length_px: Doubles
    median_px: float
    is_ground: Bools
    is_obstacle: Bools
    is_called: Bools
    """Whether the dominant map says obstacle."""

    def auroc(self, *, about_median: bool) -> float | None:
        """Return how well ε, or the length alone, tells obstacle from ground; None unless there are both."""
        score = np.abs(self.length_px - self.median_px) if about_median else self.length_px
        ground, obstacle = np.sort(score[self.is_ground]), score[self.is_obstacle]
        if not len(ground) or not len(obstacle):
            return None
        below = np.searchsorted(ground, obstacle, "left") + np.searchsorted(ground, obstacle, "right")
        return float(below.mean()) / (2 * len(ground))


def norms_of(components: Components, which: int, plane: Plane | None, truth: Truth | None) -> Norms:
    """Return the sorted lengths of v_alpha (0) or v_beta (1) over the cells that were separated."""
    valid = components.valid != 0
    length_px = np.linalg.norm(component_px(components, which).uv[valid].astype(np.float64), axis=-1)
    order = np.argsort(length_px, kind="stable")
    kinds = kinds_of(truth, components)
    called = np.zeros_like(valid) if plane is None or plane.valid.shape != valid.shape else plane.obstacle != 0
    of_cells = (cells[valid][order] for cells in (*kinds, called))
    return Norms(length_px[order], float(np.median(length_px)) if len(length_px) else 0.0, *of_cells)
