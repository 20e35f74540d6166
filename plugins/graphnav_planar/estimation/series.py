"""Planar flow as a function of the motion: the taught series, its derivatives, and a least-squares step."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles

_RIDGE = 1e-3 * np.eye(2)
"""px^2 per m^2 and rad^2; negligible beside one vector, but keeps the step at zero without vectors."""


class Series:
    """Planar flow of the motion (v, w): ``sum_k v^a_k w^b_k B_k``.

    Parameters
    ----------
    basis
        (k, 2n), the fields B, in px: n horizontal parts, then the vertical ones.
    orders
        (2, k), the powers a and b.
    """

    def __init__(self, basis: Doubles, orders: Doubles) -> None:
        self.basis = basis
        self._orders = orders
        self._lower = np.maximum(orders - 1, 0)

    def factors(self, motions: Doubles) -> Doubles:
        """Return the factor of each field, (..., k), for motions (..., 2) in m and rad."""
        a, b = self._orders
        return np.asarray(motions[..., :1] ** a * motions[..., 1:] ** b)

    def step(self, motions: Doubles, products: Doubles, moments: Doubles) -> Doubles:
        """Return the motions (..., 2) after a Gauss-Newton step.

        ``products``: (..., k, k), of the fields with each other; ``moments``: (..., k), with the flow to be explained.
        They contain all that least squares needs of the vectors.
        """
        left = moments - np.einsum("...kl,...l->...k", products, self.factors(motions))
        slopes = self._slopes(motions)
        curvature = slopes @ products @ slopes.swapaxes(-1, -2) + _RIDGE
        return np.asarray(motions + np.linalg.solve(curvature, slopes @ left[..., None])[..., 0])

    def _slopes(self, motions: Doubles) -> Doubles:
        """Return the derivatives of the factors by v and w, (..., 2, k)."""
        (a, b), (a_lower, b_lower) = self._orders, self._lower
        v, w = motions[..., :1], motions[..., 1:]
        return np.stack([a * v**a_lower * w**b, v**a * b * w**b_lower], axis=-2)
