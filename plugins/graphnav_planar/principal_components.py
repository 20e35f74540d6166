"""Principal components of the flows of a drive, of which some vectors are missing."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graphnav.arrays import Bools, Doubles, Floats

_ITERATIONS = 6
_RIDGE_RATIO = 1e-9
_MIN_FRAMES_OF_FIELD = 3
_MIN_LENGTH_PX = 1e-4
"""A component whose vectors are shorter, root mean square, is rounding: the drive does not have so many."""


class Components(NamedTuple):
    """Fields that explain the flows of a drive.

    ``given``: (g, n, 2), those of the given factors. ``fields``: (k, n, 2), px, the components, for factors whose root
    mean square is 1, the longest first. ``residual``: (n,), root mean square, px.
    """

    given: Doubles
    fields: Doubles
    residual: Doubles


def principal_components(given: Doubles, uv_px: Floats, valid: Bools, count: int) -> Components | None:
    """Return the principal components, about zero, of what ``given`` factors leave of flows with missing vectors.

    ``given``: (frames, g), ``uv_px``: (frames, n, 2), ``valid``: (frames, n). Alternating least squares over the valid
    vectors: fields for each cell, then factors for each frame [WI]; it starts from the singular vectors with zeros for
    what is missing. The fields of the given factors are fitted along: fitted before, they would differ from cell to
    cell by the components of the frames in which a cell is missing. The components' factors do not correlate with the
    given ones. None if the frames do not determine so many fields.

    References
    ----------
    .. [WI] T. Wiberg, Computation of principal components when data are missing, COMPSTAT 1976.
    """
    weights = valid.astype(np.float32)
    n_given = given.shape[1]
    if not _are_enough(weights, n_given + count):
        return None
    known = uv_px * weights[..., None]
    left = known - np.tensordot(given, _fields(given, known, weights), 1) * weights[..., None]
    factors = _first_vectors(left.reshape(len(left), -1), count)
    for _ in range(_ITERATIONS):
        fields = _fields(np.hstack([given, factors]), known, weights)
        left = known - np.tensordot(given, fields[:n_given], 1) * weights[..., None]
        factors = _factors(fields[n_given:], left, weights)
        factors -= given @ np.linalg.lstsq(given, factors, rcond=None)[0]
    fields = _fields(np.hstack([given, factors]), known, weights)
    left = known - np.tensordot(np.hstack([given, factors]), fields, 1) * weights[..., None]
    residual = np.sqrt((left * left).sum(axis=(0, 2)) / weights.sum(axis=0))
    components = _ordered(fields[n_given:], factors)
    if not np.isfinite(fields).all() or np.sqrt((components[-1] ** 2).sum(axis=-1).mean()) < _MIN_LENGTH_PX:
        return None
    return Components(fields[:n_given], components, residual)


def _are_enough(weights: Floats, n_fields: int) -> bool:
    """Return whether frames and valid vectors are enough for so many fields."""
    return len(weights) >= _MIN_FRAMES_OF_FIELD * n_fields and bool(weights.sum(axis=0).min() >= n_fields)


def _first_vectors(flows: Doubles, count: int) -> Doubles:
    """Return the left singular vectors of the largest singular values, (frames, count)."""
    return np.asarray(np.linalg.eigh(flows @ flows.T)[1][:, ::-1][:, :count])


def _fields(factors: Doubles, known: Floats, weights: Floats) -> Doubles:
    """Return the fields (k, n, 2) that fit the flows best, given the factors (frames, k)."""
    outer = (factors[:, :, None] * factors[:, None, :]).reshape(len(factors), -1)
    moments = np.tensordot(factors, known, (0, 0))
    return np.asarray(np.moveaxis(_solved(weights.T @ outer, np.moveaxis(moments, 1, 0)), 1, 0))


def _factors(fields: Doubles, known: Doubles, weights: Floats) -> Doubles:
    """Return the factors (frames, k) that fit the flows best, given the fields (k, n, 2)."""
    products = weights @ np.einsum("knd,lnd->nkl", fields, fields).reshape(weights.shape[1], -1)
    moments = known.reshape(len(known), -1) @ fields.reshape(len(fields), -1).T
    return np.asarray(_solved(products, moments[..., None])[..., 0])


def _solved(products: Doubles, moments: Doubles) -> Doubles:
    """Return the solutions (..., k, d) of the normal equations (..., k * k) and (..., k, d)."""
    k = moments.shape[-2]
    matrices = products.reshape(*products.shape[:-1], k, k)
    scale = np.sqrt(np.einsum("...kk->...k", matrices)) + np.finfo(np.float32).tiny
    scaled = matrices / (scale[..., :, None] * scale[..., None, :]) + _RIDGE_RATIO * np.eye(k)
    return np.asarray(np.linalg.solve(scaled, moments / scale[..., None]) / scale[..., None])


def _ordered(fields: Doubles, factors: Doubles) -> Doubles:
    """Return orthogonal fields of the same products, the longest first, for factors of root mean square 1."""
    span = np.linalg.qr(factors)[1] @ fields.reshape(len(fields), -1)
    rows = np.linalg.svd(span, full_matrices=False)[1:]
    signed = rows[0][:, None] * rows[1] * np.where(rows[1].sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
    return np.asarray(signed / np.sqrt(len(factors))).reshape(fields.shape)
