"""Motion of a frame from odometry of another rate."""

from __future__ import annotations

from typing import NamedTuple

import graphnav
from graphnav import Flow, Mount, Odometry, OdometryCheck, Since, Stage, Stamp, param
from graphnav_odometry.picture_check import PictureCheck
from graphnav_odometry.track import Track


class MotionOutputs(NamedTuple):
    """Outputs of `Motion`; ``check`` is for the guard."""

    motion: graphnav.Motion | None
    check: OdometryCheck


class Motion(Stage):
    """Motion over exactly the interval of a flow, interpolated from odometry with other stamps, if the picture agrees.

    Odometry and camera do not share stamps, and a motion over a different interval looks like an obstacle, or hides
    one. So the robot's pose is interpolated at the stamps of both frames, along the arc of constant speed and turning
    rate between two samples, which is exact if these do not change in between.

    Publishes no motion if the samples do not cover the interval, have a gap of more than 3 typical periods in it, or a
    jump (the odometry was reset), nor for a second after odometry has contradicted the picture. For that the motion
    of the floor is fitted to the flow, way and turn, and both are compared over 0.6 and 2 s. Only gross faults count:
    odometry that does not move while the picture does ("motionless"), moves the other way ("reversed"), or by more
    than ten times as much ("scale", as degrees). A picture that does not move says nothing here: `control.guard`
    judges that. The mounting only has to be about right: a wrong scale of 3 is not a fault. ``check`` reports all of
    it, also jumps, and is wired to the guard's ``odometry``.

    Samples that are not newer than the last are dropped. In a live run a firing waits for the sample after the flow's
    stamp, for at most ``wait_s``: odometry at 50 Hz costs 20 ms of latency.
    """

    wait_s: float = param(
        0.1,
        ge=0.0,
        le=1e6,
        doc="maximum wait of a live flow for odometry of its stamp; more is later, less loses motions",
    )
    max_extrapolation_s: float = param(
        0.0,
        ge=0.0,
        le=1e6,
        doc="maximum extrapolation beyond the last sample if no newer one has arrived; more loses fewer motions and "
        "is wrong when the robot speeds up or begins to turn",
    )
    max_speed_mps: float = param(
        5.0, gt=0.0, le=1000.0, doc="a higher speed between two samples is a reset of the odometry"
    )
    max_turn_radps: float = param(
        20.0, gt=0.0, le=1000.0, doc="a higher turning rate between two samples is a reset of the odometry"
    )
    camera_height_m: float = param(1.0, ge=0.01, le=100.0, doc=Mount.HEIGHT_DOC)
    tilt_deg: float = param(75.0, gt=0.0, le=90.0, doc=Mount.TILT_DOC)
    fov_deg: float = param(70.0, ge=5.0, le=150.0, doc=Mount.FOV_DOC)
    camera_forward_m: float = param(0.0, ge=-100.0, le=100.0, doc=Mount.FORWARD_DOC)

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget all samples."""
        self._track = Track(self.max_speed_mps, self.max_turn_radps)
        self._check = PictureCheck(Mount(self.camera_height_m, self.tilt_deg, self.fov_deg, self.camera_forward_m))

    def patience_s(self) -> float:
        """Return ``wait_s``."""
        return self.wait_s

    def step(self, flow: Flow, odometry: Since[Odometry], utime: Stamp) -> MotionOutputs:
        """Return the motion since the flow's earlier frame, None if the odometry does not determine it."""
        for sent, sample in odometry.messages:
            self._track.add(sent, sample)
        begin = utime - flow.interval_us
        moved = self._track.moved(begin, utime, self.max_extrapolation_s * 1e6)
        jump = None if moved is None else self._track.jump(begin, utime)
        self._track.forget_before(begin)
        check = self._check.check(utime, flow, moved, jump)
        if moved is None or check.fault:
            return MotionOutputs(None, check)
        motion = graphnav.Motion(
            forward_m=moved.x_m, left_m=moved.y_m, turn_rad=moved.yaw_rad, interval_us=flow.interval_us
        )
        return MotionOutputs(motion, check)
