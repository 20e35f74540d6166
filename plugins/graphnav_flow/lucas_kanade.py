"""Dense optical flow by pyramidal Lucas-Kanade."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from graphnav import Flow, Image, Stage, Stamp, param
from graphnav.arrays import Floats
from graphnav_flow.frames import Frames
from graphnav_flow.normalization import Normalization
from graphnav_flow.pyramid import Doubling, Pyramid
from graphnav_flow.refinement import Refinement
from graphnav_flow.validity import MARGIN_DOC, MARGIN_PX, MIN_TEXTURE_DOC, MIN_TEXTURE_GRAY2, Validity

_MEDIAN_PX = 3
_OUTSIDE_PX = 1e9
"""Stands for the flow outside the picture: not inf, whose product with a weight of 0 is NaN."""


class LucasKanade(Stage):
    """Dense optical flow by pyramidal Lucas-Kanade.

    From the coarsest layer down: warp the last image by the current flow, solve, upsample [OI, Algorithm 1]. Gives a
    vector for every pixel. Each iteration corrects the smoothed flow, with the mean of both images' gradients, and
    extrapolates it beyond the last image (`Refinement`); each layer ends with a median filter against outliers.
    There are two iterations on each layer above the base, where the flow approaches the solution, and one on the base.

    The first image gives no flow, nor does the first after a gap of more than 3 periods. Where neither image has
    texture, the flow is finite, small and not valid.

    A change of brightness counts as motion unless ``normalize_sigma_px`` is set (`Normalization`): on real carpet that
    grows 30 % brighter from one frame to the next, the error falls from 30 to 0.15 px. In steady light the error is 6 %
    larger and a step takes 14 % longer, so it is off by default. Choose it for every real camera; leave it off for
    floors that show little but a repeating pattern, where it raises noise above the weak texture that tells the repeats
    apart.

    ``max_disagreement_px`` doubles the time. At 1 px it removes a sixth to a quarter of the vectors that are off by
    more than a pixel where displacements are too large to be followed (two thirds to three quarters of what it removes
    are off), a quarter of what an occlusion covers, and next to nothing where the flow is right already.

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
        le=1e6,
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
    normalize_sigma_px: float | None = param(
        None,
        gt=0.0,
        le=30.0,
        doc="standard deviation of the Gaussian window in which brightness and contrast are normalized before matching,"
        " in pixels of each layer; less than 2 counts as 2; null does not normalize, 4 where the light changes",
    )
    max_disagreement_px: float | None = param(
        None,
        gt=0.0,
        le=100_000.0,
        doc="a vector is not valid if the flow of the reversed pair misses its start by more than this; null does not "
        "check, 1 is usual",
    )
    margin_px: float = param(MARGIN_PX, ge=0.0, le=100_000.0, doc=MARGIN_DOC)
    min_texture_gray2: float = param(
        MIN_TEXTURE_GRAY2, ge=0.0, le=1e6, doc=MIN_TEXTURE_DOC, renamed_from="least_texture"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget the last image."""
        self._frames = Frames()
        self._validity = Validity(self.margin_px, self.min_texture_gray2)
        self._enlargement = Enlargement(self.smooth_px)
        self._pyramids: list[Pyramid] = []
        self._normalization: Normalization | None = None

    def step(self, image: Image, stamp: Stamp) -> Flow | None:
        """Return the flow since the last image, None without one."""
        gray, interval_us = self._frames.next(image, stamp)
        if not self._pyramids:
            self._make_buffers(*gray.shape)
        self._pyramids.reverse()
        now, last = self._pyramids
        now.fill(gray)
        if self._normalization:
            self._normalization.normalize(now.layers)
        if not interval_us:
            return None
        uv_px = self._solve(now, last)
        valid = self._validity.mark(uv_px, gray if self._normalization else now.layers[0])
        if self.max_disagreement_px is not None:
            off_px = self._consistency.disagreement_px(uv_px, self._solve(last, now))
            valid &= off_px <= self.max_disagreement_px
        return Flow(uv_px=uv_px, valid=valid, interval_us=interval_us)

    def _make_buffers(self, rows: int, cols: int) -> None:
        self._pyramids = [Pyramid(rows, cols, self.layers) for _ in range(2)]
        self._doubling = Doubling(rows, cols)
        self._consistency = Consistency(rows, cols)
        if self.normalize_sigma_px is not None:
            shapes = [layer.shape for layer in self._pyramids[0].layers]
            self._normalization = Normalization(shapes, self.normalize_sigma_px)
        self._merged, self._filtered = np.empty((2, rows, cols, 2), np.float32)
        self._refinements = [
            Refinement(
                *plane.shape,
                window_px=2 * self.window_radius_px + 1,
                regularization_gray2=self.regularization_gray2,
                zoom=1 if layer else 2,
            )
            for layer, plane in enumerate(self._pyramids[0].layers)
        ]

    def _solve(self, now: Pyramid, last: Pyramid) -> Floats:
        """Return the displacement since the last frame, from the coarsest layer down."""
        box = (self.smooth_px, self.smooth_px)
        above: Refinement | None = None
        for layer in reversed(range(len(now.layers))):
            here = self._refinements[layer]
            if above is None:
                here.field.fill(0)
            else:
                for plane in above.planes:
                    cv2.medianBlur(plane, _MEDIAN_PX, plane)
                self._enlargement.enlarge(above.planes, here.planes)
            target = now.layers[layer]
            if layer:
                here.improve(target, last.layers[layer])
                for plane in here.planes:
                    cv2.blur(plane, box, plane)
                # Farther up the structure tensor still changes with the warp: large motion would be lost.
                here.improve(target, last.layers[layer], keep_tensor=layer == 1)
            else:
                here.improve(target, self._doubling.double(last.layers[0]))
            above = here
        cv2.merge(here.planes, self._merged)
        cv2.medianBlur(self._merged, _MEDIAN_PX, self._filtered)
        uv_px: Floats = cv2.blur(self._filtered, box)
        return uv_px


class Consistency:
    """Measures by how much two flows of a pair of one size disagree; reuses its buffers."""

    def __init__(self, rows: int, cols: int) -> None:
        down, right = np.mgrid[:rows, :cols].astype(np.float32)
        self._places = np.dstack([right, down])
        self._source, self._met = np.empty((2, rows, cols, 2), np.float32)

    def disagreement_px(self, forward: Floats, backward: Floats) -> Floats:
        """Return the length of u(x) + w(x - u(x)), float32 (rows, cols); huge where x - u(x) lies outside the picture.

        ``forward``: u, displacement since the last frame of what is now at x. ``backward``: w, the same of the reversed
        pair, on the pixels of the last frame. Both float32 (rows, cols, 2).
        """
        np.subtract(self._places, forward, self._source)
        cv2.remap(backward, self._source, None, cv2.INTER_LINEAR, self._met, cv2.BORDER_CONSTANT, (_OUTSIDE_PX, 0))
        np.add(self._met, forward, self._met)
        length: Floats = cv2.magnitude(self._met[..., 0], self._met[..., 1])
        return length


class Enlargement:
    """Doubles a field in size and value, and averages it over a box of ``smooth_px`` of the larger layer.

    The average is taken before, where it costs a quarter: over half the box, whose outer pixels count in part.
    """

    def __init__(self, smooth_px: int) -> None:
        width = max(smooth_px / 2, 1)
        inner = 2 * int((width - 1) / 2) + 1
        rest = (width - inner) / 2
        kernel = np.array([rest, *[1] * inner, rest]) / width
        # Applied along rows and columns: the product doubles the values.
        self._kernel = (kernel * np.sqrt(2)).astype(np.float32)

    def enlarge(self, planes: Sequence[Floats], larger: Sequence[Floats]) -> None:
        """Write each of ``planes``, (rows, cols), which it overwrites, to one of ``larger``; pixel i to pixel 2i."""
        for plane, out in zip(planes, larger, strict=True):
            rows, cols = out.shape
            cv2.sepFilter2D(plane, -1, self._kernel, self._kernel, plane)
            cv2.pyrUp(plane, out, (cols, rows))
