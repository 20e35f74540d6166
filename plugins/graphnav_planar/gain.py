"""Planar flow as the taught mean times a fitted gain."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import numpy.typing as npt

from graphnav import Flow, Planar, Role, param
from graphnav.arrays import Bools, Doubles
from graphnav_planar.estimation.robust import NOISE_DOC, NOISE_PX, weights
from graphnav_planar.estimation.series import dot
from graphnav_planar.fitted import fitted
from graphnav_planar.mean import Mean

_ITERATIONS = 10
_MIN_PX2 = 1e-12


class Gain(Mean):
    """Planar flow as the taught mean times a gain, fitted to the flow of the frame.

    The baseline of `planar.subspace` and `planar.motion`: it adapts to the speed, but not to turns, and so shows
    whether the motion must be modelled. The gain starts from the median over the vectors (of how much of the mean
    each holds), then least squares are reweighted so that obstacles do not count. Where less than 6 vectors are valid
    there is nothing to fit, and no cell of the planar flow is.
    """

    role: ClassVar[Role] = "baseline"

    noise_px: float = param(NOISE_PX, gt=0.0, le=100_000.0, doc=NOISE_DOC)

    def step(self, flow: Flow) -> Planar:
        """Return the mean times the gain for the grid of ``flow``.

        Raises
        ------
        ValueError
            The flow is of another image size than the model.
        """
        return fitted(self._model, flow, self._scaled)

    def _scaled(self, uv_px: Doubles, counts: Bools) -> npt.NDArray[np.floating]:
        """Return the mean times the gain, (rows, cols, 2)."""
        mean_px = self._mean_px.reshape(-1).astype(np.float64)
        flows, products, squares = dot(uv_px, uv_px), dot(mean_px, uv_px), dot(mean_px, mean_px)
        gain = float(np.median((products / np.maximum(squares, _MIN_PX2))[counts]))
        counted = counts.astype(np.float64)
        for _ in range(_ITERATIONS):
            weight = weights(flows - 2 * gain * products + gain * gain * squares, self.noise_px, counted)
            gain = float(weight @ products) / max(float(weight @ squares), _MIN_PX2)
        return np.asarray(gain * self._mean_px)
