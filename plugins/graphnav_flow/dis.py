"""Dense optical flow by dense inverse search, through OpenCV."""

from __future__ import annotations

from typing import Literal

import cv2
import numpy as np

from graphnav import Flow, Image, Stage, Stamp, param
from graphnav.arrays import Bytes
from graphnav_flow.frames import Frames
from graphnav_flow.validity import MARGIN_DOC, MARGIN_PX, MIN_TEXTURE_DOC, MIN_TEXTURE_GRAY2, Validity

_PRESETS = {
    "ultrafast": cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST,
    "fast": cv2.DISOPTICAL_FLOW_PRESET_FAST,
    "medium": cv2.DISOPTICAL_FLOW_PRESET_MEDIUM,
}

_MIN_SIDE_PX = 32
"""Smaller images make OpenCV raise, return NaN or crash, depending on their proportions."""


class Dis(Stage):
    """Dense optical flow by dense inverse search [K], OpenCV's implementation.

    The first image gives no flow, nor does the first after a gap of more than 3 periods.

    References
    ----------
    .. [K] T. Kroeger, R. Timofte, D. Dai, L. Van Gool, Fast Optical Flow using Dense Inverse Search, ECCV 2016.
    """

    preset: Literal["ultrafast", "fast", "medium"] = param(
        "medium", doc="ultrafast and fast skip the finest layers; medium refines at half the resolution"
    )
    margin_px: float = param(MARGIN_PX, ge=0.0, le=100_000.0, doc=MARGIN_DOC)
    min_texture_gray2: float = param(
        MIN_TEXTURE_GRAY2, ge=0.0, le=1e6, doc=MIN_TEXTURE_DOC, renamed_from="least_texture"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget the last image."""
        self._frames = Frames()
        self._validity = Validity(self.margin_px, self.min_texture_gray2)
        self._last: Bytes | None = None
        self._search = cv2.DISOpticalFlow.create(_PRESETS[self.preset])

    def step(self, image: Image, stamp: Stamp) -> Flow | None:
        """Return the flow since the last image, None without one.

        Raises
        ------
        ValueError
            The size of the images changes or is too small.
        """
        gray, interval_us = self._frames.next(image, stamp)
        if min(gray.shape) < _MIN_SIDE_PX:
            rows, cols = gray.shape
            raise ValueError(f"the image is {cols}x{rows}, but each side must have at least {_MIN_SIDE_PX} pixels")
        last, self._last = self._last, gray
        if last is None or not interval_us:
            return None
        uv_px = self._search.calc(gray, last, None)
        np.negative(uv_px, uv_px)
        return Flow(uv_px=uv_px, valid=self._validity.mark(uv_px, gray), interval_us=interval_us)
