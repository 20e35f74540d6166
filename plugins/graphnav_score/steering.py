"""Whether steering points to the freer side, and how certain its direction is."""

from __future__ import annotations

import math
from array import array
from collections.abc import Mapping
from typing import ClassVar

import cv2
import numpy as np

import graphnav
from graphnav import Metric, Role, Stage, Truth, param
from graphnav_score.frame_metrics import of_frames


class Steering(Stage):
    """Whether the control force points to the side with less true obstacle, and how certain its direction is.

    A frame counts for the side if the shares of the picture that are obstacle in its left and in its right half differ
    clearly.
    """

    role: ClassVar[Role] = "score"
    metrics: ClassVar[tuple[Metric, ...]] = of_frames(
        Metric("frames", better="neither", bounds=(0.0, None), help="Frames that count for the side."),
        Metric(
            "right_sign_ratio",
            unit="ratio",
            better="higher",
            bounds=(0.0, 1.0),
            min_difference=0.02,
            help="Share of them in which the force points to the freer side; no force to either side is wrong; left "
            "out without such a frame.",
        ),
        Metric(
            "median_eigenvalue_ratio",
            unit="ratio",
            better="higher",
            bounds=(1.0, None),
            min_difference=0.1,
            help="First over second eigenvalue of the gradients' covariance, median over all frames with a gradient; "
            "near 1 the principal direction is arbitrary; left out if infinite.",
        ),
    )

    min_side_ratio: float = param(
        2.0,
        ge=1.0,
        le=1e6,
        doc="a frame counts if one half holds at least this many times the obstacle of the other",
        renamed_from="least_times",
    )
    min_difference_ratio: float = param(
        0.05,
        gt=0.0,
        le=0.5,
        doc="and if they differ by at least this share of the picture",
        renamed_from="least_difference_ratio",
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget everything counted."""
        self._frames = self._right = 0
        self._ratios = array("d")

    def step(self, steering: graphnav.Steering, truth: Truth) -> None:
        """Count this frame."""
        first, second = steering.eigenvalues.tolist()
        if first > 0:
            self._ratios.append(first / second if second > 0 else math.inf)
        obstacle = truth.obstacle
        total = cv2.countNonZero(obstacle)
        min_difference = self.min_difference_ratio * obstacle.size
        if total < min_difference:
            return
        cols = obstacle.shape[1]
        half = cols // 2
        left = cv2.countNonZero(obstacle[:, :half])
        right = total - left
        if cols % 2:
            right -= cv2.countNonZero(obstacle[:, half : half + 1])
        if abs(left - right) < min_difference or max(left, right) < self.min_side_ratio * min(left, right):
            return
        self._frames += 1
        to_the_right = float(steering.control[0])
        self._right += to_the_right > 0 if left > right else to_the_right < 0

    def summary(self) -> Mapping[str, float]:
        """Return the metrics that are defined."""
        values = {"frames": float(self._frames)}
        if self._frames:
            values["right_sign_ratio"] = self._right / self._frames
        if self._ratios and math.isfinite(median := float(np.median(self._ratios))):
            values["median_eigenvalue_ratio"] = median
        return values
