"""Whether steering agrees with an oracle's."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from graphnav import Metric, Role, Stage, Steering, param
from graphnav_score.frame_metrics import of_frames


class Agreement(Stage):
    """How well steering agrees with an oracle's on the same frames, whichever of the two drives."""

    role: ClassVar[Role] = "score"
    metrics: ClassVar[tuple[Metric, ...]] = of_frames(
        Metric("frames", better="neither", bounds=(0.0, None), help="Frames that had both."),
        Metric(
            "angle_error_rad",
            unit="rad",
            better="lower",
            bounds=(0.0, math.pi),
            min_difference=0.02,
            help="Mean angle between the two directions, 0 to pi; left out without a frame.",
        ),
        Metric(
            "right_sign_ratio",
            unit="ratio",
            better="higher",
            bounds=(0.0, 1.0),
            min_difference=0.02,
            help="Of the frames in which the oracle turns by at least `min_turn_deg`, the share in which the steering "
            "turns to the same side; straight ahead is wrong; left out without such a frame.",
        ),
    )

    min_turn_deg: float = param(
        5.0,
        ge=0.0,
        lt=180.0,
        doc="minimum angle of the oracle for the side to count; less adds unclear frames",
        renamed_from="least_turn_deg",
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget everything counted."""
        self._frames = self._turns = self._right = 0
        self._sum_rad = 0.0

    def step(self, steering: Steering, oracle: Steering) -> None:
        """Count this frame."""
        self._frames += 1
        self._sum_rad += abs(math.remainder(steering.theta_rad - oracle.theta_rad, 2 * math.pi))
        if abs(oracle.theta_rad) >= math.radians(self.min_turn_deg) and oracle.theta_rad:
            self._turns += 1
            self._right += steering.theta_rad * oracle.theta_rad > 0

    def summary(self) -> Mapping[str, float]:
        """Return the metrics that are defined."""
        values = {"frames": float(self._frames)}
        if self._frames:
            values["angle_error_rad"] = self._sum_rad / self._frames
        if self._turns:
            values["right_sign_ratio"] = self._right / self._turns
        return values
