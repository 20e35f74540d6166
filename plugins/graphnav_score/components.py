"""Which of the two independent components tells obstacle from ground."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import cv2
import numpy as np

import graphnav
from graphnav import Metric, Role, Stage, Truth, param
from graphnav_score.frame_metrics import of_frames
from graphnav_score.pixels import count_pixels
from graphnav_score.roc import Roc

_NAMES = ("alpha", "beta")


class Components(Stage):
    """Which of the two independent components tells obstacle from ground.

    For either one the score of a cell is the deviation of its length from the median length of the frame [OI, eq. 3],
    whichever of them the detector took. Pixels and frames count as for `score.plane`; frames without motion count too.
    """

    role: ClassVar[Role] = "score"
    metrics: ClassVar[tuple[Metric, ...]] = of_frames(
        Metric("frames", better="neither", bounds=(0.0, None), help="Frames that count."),
        Metric(
            "alpha_auroc",
            better="higher",
            min_difference=0.01,
            help="Area under the receiver operating characteristic of the component whose length varies less.",
            bounds=(0.0, 1.0),
        ),
        Metric(
            "beta_auroc",
            better="higher",
            min_difference=0.01,
            help="The same of the component whose length varies more.",
            bounds=(0.0, 1.0),
        ),
        Metric(
            "median_variance_ratio",
            unit="ratio",
            better="neither",
            bounds=(0.0, None),
            help="Variance of the length of v_alpha divided by that of v_beta, median over all frames.",
        ),
        Metric(
            "alpha_taken_ratio",
            unit="ratio",
            better="neither",
            help="Share of all frames scored by v_alpha.",
            bounds=(0.0, 1.0),
        ),
    )

    min_obstacle_ratio: float = param(0.05, ge=0.0, le=1.0, doc="minimum true share of obstacle in a frame that counts")
    max_obstacle_ratio: float = param(0.5, ge=0.0, le=1.0, doc="maximum true share of obstacle in a frame that counts")

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget everything counted."""
        self._rocs = (Roc(), Roc())
        self._frames = 0
        self._variance_ratios: list[float] = []
        self._taken: list[int] = []

    def step(self, components: graphnav.Components, truth: Truth) -> None:
        """Count this frame.

        Raises
        ------
        ValueError
            The components' grid does not fit the truth.
        """
        smaller, larger = components.variances.tolist()
        self._variance_ratios.append(smaller / larger if larger else 1.0)
        self._taken.append(components.taken)
        pixels = count_pixels(truth, components.valid.shape, components.step_px)
        ground, obstacle = (float(cv2.sumElems(kind)[0]) for kind in pixels)
        if not self.min_obstacle_ratio <= obstacle / max(ground + obstacle, 1.0) <= self.max_obstacle_ratio:
            return
        self._frames += 1
        valid = components.valid != 0
        ground_pixels, obstacle_pixels = pixels[:, valid].astype(np.float64)
        for roc, field in zip(self._rocs, (components.alpha, components.beta), strict=True):
            length = np.linalg.norm(field[valid], axis=-1)
            roc.add(np.abs(length - np.median(length)), obstacle_pixels, ground_pixels)

    def summary(self) -> Mapping[str, float]:
        """Return the metrics that are defined."""
        values = {"frames": float(self._frames)}
        for name, roc in zip(_NAMES, self._rocs, strict=True):
            area = roc.area()
            if area is not None:
                values[f"{name}_auroc"] = area
        if self._taken:
            values["median_variance_ratio"] = float(np.median(self._variance_ratios))
            values["alpha_taken_ratio"] = self._taken.count(0) / len(self._taken)
        return values
