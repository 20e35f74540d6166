"""Planar flow as a function of the motion: the taught series, its derivatives, and a least-squares step."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles

_RIDGE = 1e-3 * np.eye(2)
"""px^2 per m^2 and rad^2; negligible beside one vector, but keeps the step at zero without vectors."""


class Series:
    """Planar flow of the motion (v, w): ``sum_k v^a_k w^b_k B_k``.

    Minus the flow u itself counts as one more field, of the powers 0 and 0. Then what a motion leaves of the flow has
    the squares ``f_k f_l B_k.B_l`` with f the factors: linear in products of vectors of which most never change. The
    products are kept, so that a fit needs no field of residuals.

    Parameters
    ----------
    basis
        (k, 2n), the fields B, in px: n horizontal parts, then the vertical ones.
    orders
        (2, k), the powers a and b.
    """

    def __init__(self, basis: Doubles, orders: Doubles) -> None:
        self.basis = basis
        self._orders = np.concatenate([np.zeros((2, 1)), orders], axis=1)
        self._lower = np.maximum(self._orders - 1, 0)
        k, n = len(basis), basis.shape[1] // 2
        self._first, self._second = np.triu_indices(1 + k)
        self._twice = np.where(self._first == self._second, 1.0, 2.0)
        self._pair = np.zeros((1 + k, 1 + k), np.intp)
        self._pair[self._first, self._second] = self._pair[self._second, self._first] = np.arange(len(self._first))
        self._products = np.zeros((len(self._first), n))
        self._products[1 + k :] = dot(basis[self._first[1 + k :] - 1], basis[self._second[1 + k :] - 1])

    def products(self, uv_px: Doubles) -> Doubles:
        """Return the products of each vector's fields, (products, n); the next call overwrites them.

        ``uv_px``: (2n,), the flow, laid out as the fields.
        """
        self._products[0] = dot(uv_px, uv_px)
        np.negative(dot(self.basis, uv_px), out=self._products[1 : 1 + len(self.basis)])
        return self._products

    def squares(self, motions: Doubles) -> Doubles:
        """Return the multiples (..., products) of the products that add up to the squares of the residuals, px^2."""
        powers = motions[..., None] ** self._orders
        factors = powers[..., 0, :] * powers[..., 1, :]
        return np.asarray(self._twice * factors[..., self._first] * factors[..., self._second])

    def flow(self, motion: Doubles) -> Doubles:
        """Return the planar flow (2n,) of a motion (2,) in m and rad."""
        v, w = motion[:, None] ** self._orders[:, 1:]
        return np.asarray((v * w) @ self.basis)

    def step(self, motions: Doubles, sums: Doubles) -> Doubles:
        """Return the motions (..., 2) after a Gauss-Newton step.

        ``sums``: (..., products), weighted sums of the products over the vectors. They contain all that least squares
        needs of them.
        """
        powers = motions[..., None] ** self._orders
        rows = np.empty((*motions.shape[:-1], 3, len(self._pair)))
        np.multiply(self._orders * motions[..., None] ** self._lower, powers[..., ::-1, :], out=rows[..., :2, :])
        np.multiply(powers[..., 0, :], powers[..., 1, :], out=rows[..., 2, :])
        normal = rows @ sums[..., self._pair] @ rows.swapaxes(-1, -2)
        step = np.linalg.solve(normal[..., :2, :2] + _RIDGE, normal[..., :2, 2:])
        return np.asarray(motions - step[..., 0])


def dot(fields: Doubles, other: Doubles) -> Doubles:
    """Return the products (..., n) of vectors, (..., 2n) each: n horizontal parts, then the vertical ones."""
    products = fields * other
    n = products.shape[-1] // 2
    return np.asarray(products[..., :n] + products[..., n:])
