"""Dense optical flow by Farneback's polynomial expansion, through OpenCV."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav import Flow, Image, Stage, Stamp, param
from graphnav.arrays import Bytes
from graphnav_flow.frames import Frames
from graphnav_flow.validity import MARGIN_DOC, MARGIN_PX, MIN_TEXTURE_DOC, MIN_TEXTURE_GRAY2, Validity


class Farneback(Stage):
    """Dense optical flow by polynomial expansion [F], OpenCV's implementation.

    On textures that `flow.lucas_kanade` can match it errs more. Take it, with ``window_px: 31``, where surfaces are
    nearly blank and move little: its flow is smoother, so that on a carpet between blank walls detectors separate the
    walls better. At 160x120 it has two layers above the base and loses displacements of 5 px and more on fine texture.

    The first image gives no flow, nor does the first after a gap of more than 3 periods.

    References
    ----------
    .. [F] G. Farneback, Two-Frame Motion Estimation Based on Polynomial Expansion, SCIA 2003.
    """

    layers: int = param(
        3,
        ge=0,
        le=8,
        doc="layers above the base: each doubles the displacement that can be followed; OpenCV creates none "
        "with a side below 32 pixels",
    )
    window_px: int = param(15, ge=3, le=63, doc="side of the averaging window: more is smoother and blurs edges")
    iterations: int = param(3, ge=1, le=20, doc="iterations on each layer")
    expansion_px: int = param(5, ge=3, le=9, doc="side of the neighbourhood of the polynomial expansion")
    expansion_sigma_px: float = param(1.2, gt=0.0, le=3.0, doc="its Gaussian weight; 1.1 to 1.5 suit 5 to 7 px")
    margin_px: float = param(MARGIN_PX, ge=0.0, le=100_000.0, doc=MARGIN_DOC)
    min_texture_gray2: float = param(
        MIN_TEXTURE_GRAY2, ge=0.0, le=1e6, doc=MIN_TEXTURE_DOC, renamed_from="least_texture"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget the last image."""
        self._frames = Frames()
        self._validity = Validity(self.margin_px, self.min_texture_gray2)
        self._last: Bytes | None = None

    def step(self, image: Image, stamp: Stamp) -> Flow | None:
        """Return the flow since the last image, None without one."""
        gray, interval_us = self._frames.next(image, stamp)
        last, self._last = self._last, gray
        if last is None or not interval_us:
            return None
        uv_px = cv2.calcOpticalFlowFarneback(
            gray,
            last,
            None,
            pyr_scale=0.5,
            levels=self.layers,
            winsize=self.window_px,
            iterations=self.iterations,
            poly_n=self.expansion_px,
            poly_sigma=self.expansion_sigma_px,
            flags=0,
        )
        np.negative(uv_px, uv_px)
        return Flow(uv_px=uv_px, valid=self._validity.mark(uv_px, gray), interval_us=interval_us)
