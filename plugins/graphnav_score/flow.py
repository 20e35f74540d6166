"""How far a flow is from the truth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import cv2
import numpy as np

import graphnav
from graphnav import Metric, Role, Stage, Truth, coarsen, param
from graphnav.arrays import Floats
from graphnav_score.frame_metrics import of_frames
from graphnav_score.pixels import cell_factor


class Flow(Stage):
    """How far a flow is from the truth, over all valid vectors of all frames.

    A coarser flow than the truth is compared with the truth's mean over its cells.
    """

    role: ClassVar[Role] = "score"
    metrics: ClassVar[tuple[Metric, ...]] = of_frames(
        Metric("frames", better="neither", bounds=(0.0, None), help="Frames that were compared."),
        Metric(
            "valid_ratio",
            unit="ratio",
            better="higher",
            bounds=(0.0, 1.0),
            min_difference=0.02,
            help="Share of vectors that are valid.",
        ),
        Metric(
            "epe_px",
            unit="px",
            better="lower",
            bounds=(0.0, None),
            min_difference=0.01,
            help="Mean length of the error (end-point error); left out without a valid vector.",
        ),
        Metric(
            "outlier_ratio",
            unit="ratio",
            better="lower",
            bounds=(0.0, 1.0),
            min_difference=0.01,
            help="Share of valid vectors that are off by more than `outlier_px`; left out without one.",
        ),
    )

    outlier_px: float = param(1.0, gt=0.0, le=100_000.0, doc="error above which a vector is an outlier")

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget everything counted."""
        self._frames = self._vectors = self._valid = self._outliers = 0
        self._sum_px = 0.0

    def step(self, flow: graphnav.Flow, truth: Truth) -> None:
        """Count this frame.

        Raises
        ------
        ValueError
            The flow's grid does not fit the truth.
        """
        cell_factor(truth, flow.valid.shape, flow.step_px)
        true_px = truth.flow_px if flow.step_px == truth.step_px else self._cell_means(truth, flow.step_px)
        off_px = np.abs((flow.uv_px - true_px).view(np.complex64)[..., 0])
        self._frames += 1
        self._vectors += flow.valid.size
        self._valid += cv2.countNonZero(flow.valid)
        self._sum_px += cv2.norm(off_px, cv2.NORM_L1, flow.valid)
        if cv2.norm(off_px, cv2.NORM_INF, flow.valid) > self.outlier_px:
            self._outliers += int(np.count_nonzero(off_px[flow.valid != 0] > self.outlier_px))

    def _cell_means(self, truth: Truth, step_px: int) -> Floats:
        everywhere = np.ones(truth.obstacle.shape, np.uint8)
        true = graphnav.Flow(
            uv_px=truth.flow_px, valid=everywhere, interval_us=truth.interval_us, step_px=truth.step_px
        )
        return coarsen(true, step_px).uv_px

    def summary(self) -> Mapping[str, float]:
        """Return the metrics that are defined."""
        values = {"frames": float(self._frames)}
        if self._vectors:
            values["valid_ratio"] = self._valid / self._vectors
        if self._valid:
            values["epe_px"] = self._sum_px / self._valid
            values["outlier_ratio"] = self._outliers / self._valid
        return values
