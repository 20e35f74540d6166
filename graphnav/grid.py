"""Coarsen dense fields: means over blocks of pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from graphnav.messages import Flow


def coarsen(flow: Flow, step_px: int) -> Flow:
    """Return ``flow`` averaged over blocks of ``step_px`` pixels.

    A block's vector is the mean of its valid vectors, zero without any; the block is valid if at least half of it is,
    pixels outside of the image counting as invalid. A flow of this step is returned unchanged.

    Raises
    ------
    ValueError
        ``step_px`` is not a multiple of the flow's own step.
    """
    factor, rest = divmod(step_px, flow.step_px)
    if rest or not factor:
        raise ValueError(f"cannot coarsen a flow of one vector every {flow.step_px} px to {step_px} px: not a multiple")
    if factor == 1:
        return flow
    weight = (flow.valid != 0).astype(np.float32)
    count = block_sum(weight, factor)
    vectors = np.ascontiguousarray(flow.uv_px).view(np.complex64)[..., 0]  # four times as fast as pairs of floats
    mean = block_sum(vectors * weight, factor) / np.maximum(count, 1)
    return Flow(
        uv_px=mean.view(np.float32).reshape(*mean.shape, 2),
        valid=(2 * count >= factor * factor).astype(np.uint8),
        interval_us=flow.interval_us,
        step_px=step_px,
    )


def block_sum(field: npt.NDArray[Any], factor: int) -> npt.NDArray[Any]:
    """Return the sums over blocks of ``factor`` rows and columns of ``field``, (rows, cols).

    Blocks at the border sum their part of the field: the result has ``ceil(rows / factor)`` rows.
    """
    rows, cols = field.shape
    if rows % factor or cols % factor:
        field = np.pad(field, ((0, -rows % factor), (0, -cols % factor)))
    down = sum((field[i::factor] for i in range(1, factor)), field[::factor])
    across = sum((down[:, i::factor] for i in range(1, factor)), down[:, ::factor])
    return np.asarray(across)
