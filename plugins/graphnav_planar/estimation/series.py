"""Planar flow as a function of the motion: the taught series, its derivatives, and a least-squares step."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles

_RIDGE = 1e-3
"""px^2 per m^2, rad^2 and squared factor; negligible beside one vector, but keeps the step at zero without vectors."""
_DRIVING = 2


class Series:
    """Planar flow of the motion (v, w, c): ``sum_k v^a_k w^b_k B_k + sum_i c_i C_i``.

    Minus the flow u itself counts as one more field, of the powers 0 and 0. Then what a motion leaves of the flow has
    the squares ``f_k f_l B_k.B_l`` with f the factors: linear in products of vectors of which most never change. The
    products are kept, so that a fit needs no field of residuals.

    Parameters
    ----------
    basis
        (k + n_free, 2n), the fields B and then C, in px: u and v of each vector in turn.
    orders
        (2, k), the powers a and b. Without fields B a motion is c alone.
    """

    def __init__(self, basis: Doubles, orders: Doubles) -> None:
        self.basis = basis
        self.n_free = len(basis) - orders.shape[1]
        self.n_driving = _DRIVING if orders.shape[1] else 0
        self.unknowns = self.n_driving + self.n_free
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
        """Return the derivatives of the factors f by each unknown, and f, of motions (unknowns, ...).

        (..., unknowns + 1, 1 + fields).
        """
        if not self.n_free:
            return self._driving_factors(motions)
        n_driving, first_free = self.n_driving, 1 + len(self.basis) - self.n_free
        factors = np.zeros((*motions.shape[1:], 1 + self.unknowns, 1 + len(self.basis)))
        factors[..., -1, 0] = 1.0
        if n_driving:
            driving = self._driving_factors(motions[:n_driving])
            factors[..., :n_driving, :first_free] = driving[..., :n_driving, :]
            factors[..., -1, :first_free] = driving[..., -1, :]
        factors[..., n_driving:-1, first_free:] = np.eye(self.n_free)
        factors[..., -1, first_free:] = np.moveaxis(motions[n_driving:], 0, -1)
        return factors

    def _driving_factors(self, motions: Doubles) -> Doubles:
        """Return the derivatives of the factors of 1 and B by v and by w, and these factors, (..., 3, 1 + k)."""
        v, w = motions[..., None] ** self._powers
        return np.asarray(self._multiples * v.take(self._v_powers, axis=-1) * w.take(self._w_powers, axis=-1))

    def squares(self, factors: Doubles) -> Doubles:
        """Return the multiples (..., products) of the products that add up to the squares of the residuals, px^2."""
        f = factors[..., -1, :]
        return np.asarray(self._twice * f.take(self._first, axis=-1) * f.take(self._second, axis=-1))

    def flow(self, motion: Doubles) -> Doubles:
        """Return the planar flow (2n,) of a motion (unknowns,): v in m and w in rad, then c."""
        return np.asarray(self.factors(motion)[-1, 1:] @ self.basis)

    def step(self, motions: Doubles, factors: Doubles, sums: Doubles) -> Doubles:
        """Return the motions (unknowns, ...) after a Gauss-Newton step from motions with these factors.

        ``sums``: (..., products), weighted sums of the products over the vectors. They contain all that least squares
        needs of them.
        """
        normal = self._normal(factors, sums)
        if self.n_free:
            matrix, residual = normal[..., :-1, :-1] + _RIDGE * np.eye(self.unknowns), normal[..., :-1, -1:]
            return np.asarray(motions - np.moveaxis(np.linalg.solve(matrix, residual)[..., 0], -1, 0))
        steps = np.array([_solution(*rows) for rows in normal.reshape(-1, 3, 3).tolist()])
        return np.asarray(motions - steps.T.reshape(motions.shape))

    def step_within(self, motion: Doubles, sums: Doubles, low: Doubles, high: Doubles) -> Doubles:
        """Return one motion (unknowns,) after a step that keeps v and w between ``low`` and ``high``, (2,)."""
        factors = self.factors(motion)
        normal = self._normal(factors, sums)
        driving = np.clip(self.step(motion, factors, sums)[:_DRIVING], low, high)
        matrix = normal[_DRIVING:-1, _DRIVING:-1] + _RIDGE * np.eye(self.n_free)
        residual = normal[_DRIVING:-1, -1] + normal[_DRIVING:-1, :_DRIVING] @ (driving - motion[:_DRIVING])
        return np.concatenate([driving, motion[_DRIVING:] - np.linalg.solve(matrix, residual)])

    def _normal(self, factors: Doubles, sums: Doubles) -> Doubles:
        """Return the products of all derivatives and the residual, (..., unknowns + 1, unknowns + 1)."""
        return np.asarray(factors @ sums.take(self._pair, axis=-1) @ factors.swapaxes(-1, -2))


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
