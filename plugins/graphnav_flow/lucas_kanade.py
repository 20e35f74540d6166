"""Dense optical flow by pyramidal Lucas-Kanade."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from graphnav import Flow, FlowDeviation, Image, Stage, Stamp, param
from graphnav.arrays import Bytes, Floats
from graphnav_flow.deviation import STEP_PX, Deviation
from graphnav_flow.frames import Frames
from graphnav_flow.light import LAYER, change_of_light
from graphnav_flow.normalization import Normalization
from graphnav_flow.pyramid import Doubling, Pyramid
from graphnav_flow.refinement import Refinement, box, thinned
from graphnav_flow.validity import MARGIN_DOC, MARGIN_PX, MIN_TEXTURE_DOC, Inside, Texture

_MEDIAN_PX = 3
_REGULARIZATION_RATIOS = (1.0, 2.0, 4.0)
"""Of the base, the layer above it, and those farther up. A pattern that repeats is nearly gone on layers that do not
resolve its period, and what noise is left there moves in any direction; natural texture is stronger the coarser the
layer. Twice as much loses a floor of low contrast: EPE 0.16 in place of 0.11 px."""
_BASE_EVERY = 2
"""On the base the flow is solved at every second pixel: 9 px of window and 11 px of average leave nothing finer."""
_OUTSIDE_PX = 1e9
"""Stands for the flow outside the picture: not inf, whose product with a weight of 0 is NaN."""


class FlowOutputs(NamedTuple):
    """The flow, and how far each of its vectors is likely to be off."""

    flow: Flow
    deviation: FlowDeviation


class LucasKanade(Stage):
    """Dense optical flow by pyramidal Lucas-Kanade.

    From the coarsest layer down: warp the last image by the current flow, solve, upsample [OI, Algorithm 1]. Gives a
    vector for every pixel. Each iteration corrects the smoothed flow, with the mean of both images' gradients, and
    extrapolates it beyond the last image (`Refinement`); each layer above the base ends with a median filter against
    outliers. There are two iterations on each of these, where the flow approaches the solution, and one on the base, at
    every second pixel.

    The first image gives no flow, nor does the first after a gap of more than 3 periods.

    A vector is valid where it is likely to be off by at most ``max_deviation_px`` (`Deviation`), as both pictures tell:
    not where there is no texture, nor where it does not stand out from the noise, nor where the pictures do not match.
    ``deviation`` is published on blocks of 4 px, for stages that weigh by it.

    A change of brightness counts as motion: a step of 15 % raises the error from 0.03 to 1 px. Where brightness has
    changed by more than ``light_ratio``, as the layers tell that are solved first, both images are normalized
    (`Normalization`). Always to do so would raise the error in steady light by 6 % on textured floors, by half on
    smooth ones, and beyond use on tiles.

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
        4.0,
        gt=0.0,
        le=30.0,
        doc="standard deviation of the Gaussian window in which brightness and contrast are normalized where the light "
        "has changed, in pixels of each layer; less than 2 counts as 2; null does not normalize",
    )
    light_ratio: float = param(
        0.012, ge=0.0, le=1.0, doc="change of brightness from which on images are normalized; 0 always does"
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
        0.0,
        ge=0.0,
        le=1e6,
        doc=f"{MIN_TEXTURE_DOC}, beside ``max_deviation_px``; 0 does not ask",
        renamed_from="least_texture",
    )
    max_deviation_px: float = param(
        0.5, gt=0.0, le=100_000.0, doc="a vector is not valid if it is likely to be off by more than this (`Deviation`)"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget the last image."""
        self._frames = Frames()
        self._enlargement = Enlargement(self.smooth_px)
        self._average = thinned(self.smooth_px)
        self._pyramids: list[Pyramid] = []
        self._normalization: Normalization | None = None

    def step(self, image: Image, stamp: Stamp) -> FlowOutputs | None:
        """Return the flow since the last image with its deviation, None without one."""
        gray, interval_us = self._frames.next(image, stamp)
        if not self._pyramids:
            self._make_buffers(*gray.shape)
        self._pyramids.reverse()
        now, last = self._pyramids
        now.fill(gray)
        if not interval_us:
            return None
        uv_px = self._solve(now, last)
        deviation_px = self._deviation.predict_px(self._refinements, now, self._merged, uv_px)
        valid = self._mark(uv_px, deviation_px, gray)
        if self.max_disagreement_px is not None:
            off_px = self._consistency.disagreement_px(uv_px, self._solve(last, now))
            valid &= off_px <= self.max_disagreement_px
        return FlowOutputs(
            Flow(uv_px=uv_px, valid=valid, interval_us=interval_us),
            FlowDeviation(deviation_px=deviation_px, step_px=STEP_PX),
        )

    def _mark(self, uv_px: Floats, deviation_px: Floats, gray: Bytes) -> Bytes:
        """Return 1 where the flow is valid, uint8 (rows, cols)."""
        inside = self._inside.mark(uv_px)
        if self.min_texture_gray2:
            self._texture.clear_below(self.min_texture_gray2, gray, inside)
        valid = inside.view(np.uint8)
        is_known = (deviation_px <= self.max_deviation_px).view(np.uint8)
        if not is_known.all():
            rows, cols = (STEP_PX * side for side in is_known.shape)
            known = cv2.resize(is_known, (cols, rows), interpolation=cv2.INTER_NEAREST)
            np.bitwise_and(valid, known[: valid.shape[0], : valid.shape[1]], valid)
        return valid

    def _make_buffers(self, rows: int, cols: int) -> None:
        self._pyramids = [Pyramid(rows, cols, self.layers) for _ in range(2)]
        self._doubling = Doubling(rows, cols)
        self._consistency = Consistency(rows, cols)
        self._inside, self._texture = Inside(rows, cols, self.margin_px), Texture(rows, cols)
        self._deviation = Deviation(rows, cols, 2 * self.window_radius_px + 1, self.smooth_px)
        if self.normalize_sigma_px is not None:
            shapes = [layer.shape for layer in self._pyramids[0].layers]
            self._normalization = Normalization(shapes, self.normalize_sigma_px)
        solved = -(-rows // _BASE_EVERY), -(-cols // _BASE_EVERY), 2
        self._merged, self._averaged = np.empty((2, *solved), np.float32)
        self._refinements = [
            Refinement(
                *plane.shape,
                window_px=2 * self.window_radius_px + 1,
                regularization_gray2=_REGULARIZATION_RATIOS[min(layer, 2)] * self.regularization_gray2,
                zoom=1 if layer else 2,
                every=1 if layer else _BASE_EVERY,
            )
            for layer, plane in enumerate(self._pyramids[0].layers)
        ]

    def _solve(self, now: Pyramid, last: Pyramid) -> Floats:
        """Return the displacement since the last frame, from the coarsest layer down."""
        top, coarse = len(now.layers) - 1, min(LAYER, len(now.layers) - 1)
        always = self._normalization is not None and not self.light_ratio
        if not always:
            self._descend(now, last, top, coarse)
        if self._normalization and (always or self._light_changes(now.layers[coarse], last.layers[coarse], coarse)):
            now, last = (one.normalized(self._normalization) for one in (now, last))
            self._descend(now, last, top, coarse)
        self._descend(now, last, coarse - 1, 0)
        cv2.merge(self._refinements[0].solved, self._merged)
        cv2.sepFilter2D(
            self._merged, -1, self._average, self._average, self._averaged, (-1, -1), 0.0, cv2.BORDER_REPLICATE
        )
        uv_px: Floats = cv2.pyrUp(self._averaged, None, now.layers[0].shape[::-1])
        return uv_px

    def _light_changes(self, now: Floats, last: Floats, layer: int) -> bool:
        return change_of_light(now, self._refinements[layer].warped(now, last)) > self.light_ratio

    def _descend(self, now: Pyramid, last: Pyramid, first: int, end: int) -> None:
        """Solve from the layer ``first`` down to ``end``; it is the coarsest or one below the last that was solved."""
        box = (self.smooth_px, self.smooth_px)
        for layer in range(first, end - 1, -1):
            here = self._refinements[layer]
            if layer == len(now.layers) - 1:
                here.field.fill(0)
            else:
                above = self._refinements[layer + 1].planes
                for plane in above:
                    cv2.medianBlur(plane, _MEDIAN_PX, plane)
                self._enlargement.enlarge(above, here.planes)
            target = now.layers[layer]
            if layer:
                here.improve(target, last.layers[layer])
                for plane in here.planes:
                    cv2.blur(plane, box, plane)
                # Farther up the structure tensor still changes with the warp: large motion would be lost.
                here.improve(target, last.layers[layer], keep_tensor=layer == 1)
            else:
                here.improve(target, self._doubling.double(last.layers[0]))


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
        # Applied along rows and columns: the product doubles the values.
        self._kernel = box(max(smooth_px / 2, 1.0)) * np.float32(np.sqrt(2))

    def enlarge(self, planes: Sequence[Floats], larger: Sequence[Floats]) -> None:
        """Write each of ``planes``, (rows, cols), which it overwrites, to one of ``larger``; pixel i to pixel 2i."""
        for plane, out in zip(planes, larger, strict=True):
            rows, cols = out.shape
            cv2.sepFilter2D(plane, -1, self._kernel, self._kernel, plane)
            cv2.pyrUp(plane, out, (cols, rows))
