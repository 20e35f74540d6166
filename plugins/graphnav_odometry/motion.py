"""The motion of a frame from odometry of another rate."""

from __future__ import annotations

import graphnav
from graphnav import Flow, Odometry, Since, Stage, Stamp, param
from graphnav_odometry.track import Track


class Motion(Stage):
    """Motion over exactly the interval that a flow covers, interpolated from odometry with stamps of its own.

    Odometry and camera do not share stamps, and a motion over another interval than the flow's looks like an obstacle,
    or hides one. So the robot's pose is interpolated at the stamps of both frames, along the arc of constant speed and
    turning rate between two samples, which is exact as long as these do not change in between.

    Publishes nothing where the samples do not cover the interval, leave a gap of more than 3 of their usual periods in
    it, or jump in it (the odometry was reset). Samples that are not newer than the last are dropped. Live, a firing
    waits for the sample after the flow's stamp, for ``wait_s`` at most: odometry at 50 Hz costs 20 ms of latency.
    """

    wait_s: float = param(
        0.1, ge=0.0, doc="live, how long a flow waits for odometry as new as itself; more is later, less loses motions"
    )
    max_extrapolation_s: float = param(
        0.0,
        ge=0.0,
        doc="how far beyond the last sample its speeds may be trusted where no newer one has come; more loses fewer "
        "motions and errs where the robot speeds up or begins to turn",
    )
    max_speed_mps: float = param(5.0, gt=0.0, doc="samples that imply more speed than this are a reset of the odometry")
    max_turn_radps: float = param(20.0, gt=0.0, doc="likewise, of the turning rate")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget all samples."""
        self._track = Track(self.max_speed_mps, self.max_turn_radps)

    def patience_s(self) -> float:
        """Return ``wait_s``."""
        return self.wait_s

    def step(self, flow: Flow, odometry: Since[Odometry], utime: Stamp) -> graphnav.Motion | None:
        """Return the motion since the flow's earlier frame, None where the odometry does not tell it."""
        for sent, sample in odometry.messages:
            self._track.add(sent, sample)
        begin = utime - flow.interval_us
        moved = self._track.moved(begin, utime, self.max_extrapolation_s * 1e6)
        self._track.forget_before(begin)
        if moved is None:
            return None
        return graphnav.Motion(
            forward_m=moved.x_m, left_m=moved.y_m, turn_rad=moved.yaw_rad, interval_us=flow.interval_us
        )
