"""Planar flow as a function of the motion: the taught series, its derivatives, and a least-squares step."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles

_RIDGE = 1e-3
"""px^2 per m^2 and rad^2; negligible beside one vector, but keeps the step at zero without vectors."""


class Series:
    """Planar flow of the motion (v, w): ``sum_k v^a_k w^b_k B_k``.

    Minus the flow u itself counts as one more field, of the powers 0 and 0. Then what a motion leaves of the flow has
    the squares ``f_k f_l B_k.B_l`` with f the factors: linear in products of vectors of which most never change. The
    products are kept, so that a fit needs no field of residuals.

    Parameters
    ----------
    basis
        (k, 2n), the fields B, in px: u and v of each vector in turn.
    orders
        (2, k), the powers a and b.
    """

    def __init__(self, basis: Doubles, orders: Doubles) -> None:
        self.basis = basis
        a, b = np.concatenate([np.zeros((2, 1)), orders], axis=1).astype(np.intp)
        # Rows: the derivatives of the factors by v and by w, and the factors, each a multiple of v^a w^b.
        self._multiples = np.array([a, b, np.ones_like(a)], np.float64)
        self._v_powers = np.array([np.maximum(a - 1, 0), a, a])
        self._w_powers = np.array([b, np.maximum(b - 1, 0), b])
        self._powers = np.arange(1.0 + max(a.max(), b.max()))
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
        self._products[1 : 1 + len(self.basis)] = dot(self.basis, -uv_px)
        return self._products

    def factors(self, motions: Doubles) -> Doubles:
        """Return the derivatives of the factors f by v and by w, and f, (..., 3, 1 + k), of motions (2, ...)."""
        v, w = motions[..., None] ** self._powers
        return np.asarray(self._multiples * v.take(self._v_powers, axis=-1) * w.take(self._w_powers, axis=-1))

    def squares(self, factors: Doubles) -> Doubles:
        """Return the multiples (..., products) of the products that add up to the squares of the residuals, px^2."""
        f = factors[..., 2, :]
        return np.asarray(self._twice * f.take(self._first, axis=-1) * f.take(self._second, axis=-1))

    def flow(self, motion: Doubles) -> Doubles:
        """Return the planar flow (2n,) of a motion (2,) in m and rad."""
        return np.asarray(self.factors(motion)[2, 1:] @ self.basis)

    def step(self, motions: Doubles, factors: Doubles, sums: Doubles) -> Doubles:
        """Return the motions (2, ...) after a Gauss-Newton step from motions with these factors.

        ``sums``: (..., products), weighted sums of the products over the vectors. They contain all that least squares
        needs of them.
        """
        normal = factors @ sums.take(self._pair, axis=-1) @ factors.swapaxes(-1, -2)
        steps = np.array([_solution(*rows) for rows in normal.reshape(-1, 3, 3).tolist()])
        return np.asarray(motions - steps.T.reshape(motions.shape))


def _solution(by_v: list[float], by_w: list[float], residual: list[float]) -> tuple[float, float]:
    """Return the solution of the two normal equations, given all products of both derivatives and the residual."""
    (vv, vw, _), (_, ww, _), (vr, wr, _) = by_v, by_w, residual
    vv, ww = vv + _RIDGE, ww + _RIDGE
    determinant = vv * ww - vw * vw
    return (ww * vr - vw * wr) / determinant, (vv * wr - vw * vr) / determinant


def dot(fields: Doubles, other: Doubles) -> Doubles:
    """Return the products (..., n) of vectors, (..., 2n) each: u and v of each vector in turn."""
    products = fields * other
    return np.asarray(products[..., ::2] + products[..., 1::2])
