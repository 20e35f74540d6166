"""Fit planar flow to the flow of the frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from graphnav import Flow, Planar, PlanarModel, coarsen
from graphnav.arrays import Bools, Doubles
from graphnav_planar.taught import check_size, planar, vectors

MIN_VECTORS = 6
"""Minimum number of valid vectors for a fit."""

Fit = Callable[[Doubles, Bools], npt.NDArray[np.floating]]
"""Maps vectors (2n,) and which of them count (n,), those of `vectors`, to a field as `planar` takes it."""


def fitted(model: PlanarModel, flow: Flow, fit: Fit) -> Planar:
    """Return the result of ``fit`` for the valid vectors; if they are too few, planar flow without a valid cell.

    Raises
    ------
    ValueError
        The flow is of another image size than the model.
    """
    check_size(model, flow)
    uv_px, counts = vectors(coarsen(flow, model.step_px), model)
    if np.count_nonzero(counts) < MIN_VECTORS:
        nothing = planar(model, np.zeros((*model.valid.shape, 2)), flow.interval_us)
        return replace(nothing, planar_valid=np.zeros_like(model.valid))
    return planar(model, fit(uv_px.astype(np.float64), counts), flow.interval_us)
