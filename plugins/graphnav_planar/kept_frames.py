"""A bounded selection of the frames of a drive, spread evenly over it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from graphnav.arrays import Bools, Doubles, Floats

_MAX_FRAMES = 512
_MIN_FRAMES = 64
_MAX_VALUES = 2**24
"""Of all kept flows: 64 MB, unless so few frames of a large picture fit that nothing could be learned from them."""


class KeptFrames:
    """Every n-th frame of a drive; n doubles whenever the frames are too many."""

    def __init__(self) -> None:
        self._every = 1
        self._seen = 0
        self._frames: list[tuple[Doubles, Floats, Bools]] = []

    def add(self, factors: Doubles, uv_px: Floats, valid: Bools) -> None:
        """Consider a frame: factors (k,) of its motion, vectors (rows, cols, 2), and the cells whose vector counts."""
        if self._seen % self._every == 0:
            if len(self._frames) >= min(max(_MAX_VALUES // max(uv_px.size, 1), _MIN_FRAMES), _MAX_FRAMES):
                self._frames = self._frames[::2]
                self._every *= 2
            if self._seen % self._every == 0:
                self._frames.append((factors, uv_px.astype(np.float32), valid))
        self._seen += 1

    @property
    def count(self) -> npt.NDArray[np.int64]:
        """Number of kept frames in which each cell is valid, (rows, cols)."""
        return np.asarray(np.sum([valid for _, _, valid in self._frames], axis=0, dtype=np.int64))

    def arrays(self) -> tuple[Doubles, Floats, Bools]:
        """Return the kept factors (frames, k), vectors (frames, rows, cols, 2), and which of them count."""
        factors, uv_px, valid = zip(*self._frames, strict=True)
        return np.array(factors), np.array(uv_px), np.array(valid)
