"""Dense optical flow by pyramidal Lucas-Kanade."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav import Flow, Image, Stage, Stamp, param
from graphnav.arrays import Floats
from graphnav_flow.frames import Frames
from graphnav_flow.pyramid import Pyramid, build_pyramid
from graphnav_flow.refinement import Refinement
from graphnav_flow.validity import MARGIN_DOC, MARGIN_PX, MIN_TEXTURE_DOC, MIN_TEXTURE_GRAY2, trusted

_ITERATIONS = 2
"""Number on the layers above the base, which approach the solution; on the base one is enough."""

_MEDIAN_PX = 3


class LucasKanade(Stage):
    """Dense optical flow by pyramidal Lucas-Kanade.

    From the coarsest layer down: warp the last image by the current flow, solve, upsample [OI, Algorithm 1]. Gives a
    vector for every pixel. Each iteration corrects the smoothed flow, with the mean of both images' gradients, and
    extrapolates it beyond the last image (`Refinement`); each layer ends with a median filter against outliers.

    The first image gives no flow, nor does the first after a gap of more than 3 periods. Where neither image has
    texture, the flow is finite, small and not valid.

    References
    ----------
    .. [OI] N. Ohnishi, A. Imiya, Combination of Supervised and Unsupervised Methods for Navigation Path Mining,
       Algorithm 1.
    .. [LK] B. D. Lucas, T. Kanade, An Iterative Image Registration Technique with an Application to Stereo Vision,
       IJCAI 1981.
    """

    layers: int = param(
        3,
        ge=0,
        le=8,
        doc="K, layers above the base: each doubles the displacement that can be followed; an image too small for "
        "them gets fewer",
    )
    window_radius_px: int = param(
        4, ge=1, le=30, doc="extent of the window to each side: more is smoother and blurs the edges of obstacles"
    )
    regularization_gray2: float = param(
        1.0,
        gt=0.0,
        doc="added to the diagonal of the structure tensor; where the texture is weaker, the flow stays near that of "
        "the layer above",
        renamed_from="regularization",
    )
    smooth_px: int = param(
        11,
        ge=1,
        le=31,
        doc="side of the box that averages the flow before each iteration and at the end; less is noisier and sharper",
    )
    margin_px: float = param(MARGIN_PX, ge=0.0, doc=MARGIN_DOC)
    min_texture_gray2: float = param(MIN_TEXTURE_GRAY2, ge=0.0, doc=MIN_TEXTURE_DOC, renamed_from="least_texture")

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget the last image."""
        self._frames = Frames()
        self._last: Pyramid | None = None
        self._refinements: list[Refinement] = []

    def step(self, image: Image, stamp: Stamp) -> Flow | None:
        """Return the flow since the last image, None without one."""
        gray, interval_us = self._frames.next(image, stamp)
        last, self._last = self._last, build_pyramid(gray, self.layers)
        if last is None:
            self._refinements = self._buffers(self._last)
        if last is None or not interval_us:
            return None
        uv_px = self._solve(self._last, last)
        valid = trusted(uv_px, gray, self.margin_px, self.min_texture_gray2)
        return Flow(uv_px=uv_px, valid=valid, interval_us=interval_us)

    def _buffers(self, pyramid: Pyramid) -> list[Refinement]:
        window_px = 2 * self.window_radius_px + 1
        return [
            Refinement(
                rows,
                cols,
                window_px=window_px,
                smooth_px=self.smooth_px,
                regularization_gray2=self.regularization_gray2,
                zoom=1 if layer else 2,
            )
            for layer, (rows, cols) in enumerate(plane.shape for plane in pyramid.layers)
        ]

    def _solve(self, now: Pyramid, last: Pyramid) -> Floats:
        """Return the displacement since the last frame: the one back to it, negated."""
        u = np.zeros_like(now.layers[-1])
        v = np.zeros_like(now.layers[-1])
        for layer in reversed(range(len(now.layers))):
            target = now.layers[layer]
            source = last.layers[layer] if layer else last.doubled
            if u.shape != target.shape:
                u, v = _upsample(u, target.shape), _upsample(v, target.shape)
            for _ in range(_ITERATIONS if layer else 1):
                self._refinements[layer].improve(target, source, u, v)
            u, v = cv2.medianBlur(u, _MEDIAN_PX), cv2.medianBlur(v, _MEDIAN_PX)
        box = (self.smooth_px, self.smooth_px)
        uv_px: Floats = cv2.merge([cv2.blur(u, box), cv2.blur(v, box)])
        np.negative(uv_px, out=uv_px)
        return uv_px


def _upsample(field: Floats, shape: tuple[int, ...]) -> Floats:
    """Return ``field``, a displacement, on the layer below, whose pixels are half as large."""
    larger: Floats = cv2.resize(field, (shape[1], shape[0]))
    larger *= 2
    return larger
