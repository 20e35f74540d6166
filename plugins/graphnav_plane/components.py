"""The independent components as a message."""

from __future__ import annotations

import numpy as np

from graphnav import Components, Flow, Planar
from graphnav.arrays import Bools, Doubles


def components(cells: Flow, planar: Planar, valid: Bools, unmixing: Doubles, taken: int) -> Components:
    """Return what ``unmixing`` (2, 2) makes of flow and planar flow, in the order of the variance of their lengths.

    ``taken``: the row of ``unmixing`` that the score is made from. Means are not removed, so that the mixing of the
    components is the flow itself [OI, eq. 2].
    """
    mixtures = np.stack([cells.uv_px, planar.planar_uv_px]).astype(np.float64)
    fields = np.einsum("ij,jrck->irck", unmixing, mixtures) * valid[:, :, None]
    variances = np.linalg.norm(fields[:, valid], axis=-1).var(axis=1)
    order = np.argsort(variances, kind="stable")
    alpha, beta = fields[order].astype(np.float32)
    return Components(
        alpha=alpha,
        beta=beta,
        mixing=np.asarray(np.linalg.inv(unmixing)[:, order], np.float64),
        variances=variances[order],
        taken=int(np.flatnonzero(order == taken)[0]),
        valid=valid.astype(np.uint8),
        step_px=cells.step_px,
    )
