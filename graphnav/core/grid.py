"""Coarsen dense fields: means over blocks of pixels."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from graphnav.arrays import Floats
from graphnav.core.messages import Derived, Flow

_coarser: Derived[Flow] = Derived()
"""Flows that were coarsened, by vectors and step: several stages of a process coarsen the same received flow alike."""


def coarsen(flow: Flow, step_px: int) -> Flow:
    """Return ``flow`` averaged over blocks of ``step_px`` pixels.

    A block's vector is the mean of its valid vectors, zero without any; the block is valid if at least half of it is,
    pixels outside of the image counting as invalid. A flow of this step is returned unchanged. For a flow that is
    read-only, as received ones are, the result is read-only too, and computed once.

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
    if flow.uv_px.flags.writeable or flow.valid.flags.writeable:
        return _coarsened(flow, factor)
    of = flow.interval_us, flow.step_px, step_px
    return _coarser.of((flow.uv_px, flow.valid), of, lambda: _read_only(_coarsened(flow, factor)))


def _read_only(flow: Flow) -> Flow:
    flow.uv_px.setflags(write=False)
    flow.valid.setflags(write=False)
    return flow


def _coarsened(flow: Flow, factor: int) -> Flow:
    is_valid = flow.valid != 0
    share = block_mean(is_valid.astype(np.float32), factor)
    # Multiplying the bits of a vector by 0 or 1 also clears a NaN.
    bits = np.ascontiguousarray(flow.uv_px, np.float32).view(np.uint64)[..., 0] * is_valid
    vectors = block_mean(bits.view(np.float32).reshape(flow.uv_px.shape), factor)
    pixel = 1 / factor**2
    vectors /= np.maximum(share, np.float32(pixel))[..., None]
    # A share is a multiple of a pixel's; the limit is half a pixel below one half, so that rounding does not decide.
    return Flow(
        uv_px=vectors,
        valid=(share >= np.float32(0.5 - pixel / 2)).view(np.uint8),
        interval_us=flow.interval_us,
        step_px=factor * flow.step_px,
    )


def block_mean(field: Floats, factor: int) -> Floats:
    """Return the means over blocks of ``factor`` rows and columns of ``field``, (rows, cols) or (rows, cols, 2).

    Beyond its border the field counts as 0: the result has ``ceil(rows / factor)`` rows.
    """
    rows, cols = field.shape[:2]
    if rows % factor or cols % factor:
        field = cv2.copyMakeBorder(field, 0, -rows % factor, 0, -cols % factor, cv2.BORDER_CONSTANT, value=0)
    size = (field.shape[1] // factor, field.shape[0] // factor)
    return np.asarray(cv2.resize(field, size, interpolation=cv2.INTER_AREA), np.float32)


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
