"""Drive straight to look, stop to turn: for planar flow that is valid only while the robot drives straight."""

from __future__ import annotations

import math
import statistics

from graphnav import Continuity, Stage, Stamp, Steering, Twist, param


class StopAndLook(Stage):
    """Alternate straight drives, during which the robot chooses a direction, with turns on the spot.

    The mean planar flow of [OI, eq. 1] is that of driving straight on at the taught speed; in a turn the entire floor
    differs from it and looks like an obstacle. So this robot never does both. It drives straight on at
    ``max_speed_mps``, which must be the taught speed, and judges ``look_frames`` frames by their median direction
    theta. If that is straight ahead within ``min_turn_deg`` it drives on and looks again. Otherwise, or as
    soon as a frame shows that the way is blocked (theta beyond a right angle), it stops, turns by ``turn_ratio`` times
    theta, and looks again.

    Flow covers the time since the last frame, and the drive needs time to reach its speed. So frames count only if the
    one before was taken at least ``settle_s`` after the start; steering in the meantime, and during turns, is ignored.
    After a gap of more than 3 periods it looks again: the progress of a turn during the gap is unknown. The law of
    [OI] is T = T_m cos(theta), R = R_m sin(theta) at every frame; here a cycle of frames follows theta as the law
    would, at constant speed.

    References
    ----------
    .. [OI] N. Ohnishi, A. Imiya, Combination of Supervised and Unsupervised Methods for Navigation Path Mining,
       section 3.
    """

    max_speed_mps: float = param(
        0.3, gt=0.0, le=1000.0, doc="speed straight ahead: the one at which the mean was taught"
    )
    max_turn_radps: float = param(1.2, gt=0.0, le=1000.0, doc="maximum turning rate; less turns for longer")
    settle_s: float = param(
        0.2,
        ge=0.0,
        le=1e6,
        doc="time after a turn in which frames are ignored; less than the drive needs shows turns as obstacles",
    )
    look_frames: int = param(
        2, ge=1, le=1000, doc="frames judged together; more is more reliable and drives farther blindly"
    )
    turn_ratio: float = param(0.5, gt=0.0, le=1.0, doc="share of theta to turn by; more may oscillate")
    min_turn_deg: float = param(
        5.0,
        ge=0.0,
        lt=90.0,
        doc="a direction nearer to straight ahead is not worth a stop",
        renamed_from="least_turn_deg",
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Stand still, before the first look."""
        self._before: int | None = None
        self._continuity = Continuity()
        self._thetas_rad: list[float] = []
        self._look_since_us = 0
        self._turn_until_us: int | None = None
        self._turn = Twist(v_mps=0.0, omega_radps=0.0)

    def step(self, steering: Steering, now: Stamp) -> Twist:
        """Return the command."""
        if self._continuity.breaks(now) or self._before is None:
            self._look(now)
        elif self._turn_until_us is not None:
            if now >= self._turn_until_us:
                self._look(now)
        elif self._before - self._look_since_us >= self.settle_s * 1e6:
            self._judge(steering.theta_rad, now, now - self._before)
        self._before = now
        if self._turn_until_us is not None:
            return self._turn
        return Twist(v_mps=self.max_speed_mps, omega_radps=0.0)

    def _look(self, now: int) -> None:
        self._look_since_us, self._turn_until_us = now, None
        self._thetas_rad = []

    def _judge(self, theta_rad: float, now: int, interval_us: int) -> None:
        self._thetas_rad.append(theta_rad)
        if abs(theta_rad) <= math.pi / 2:
            if len(self._thetas_rad) < self.look_frames:
                return
            theta_rad = statistics.median(self._thetas_rad)
        self._thetas_rad = []
        if abs(theta_rad) > math.radians(self.min_turn_deg):
            self._begin_turn(self.turn_ratio * theta_rad, now, interval_us)

    def _begin_turn(self, angle_rad: float, now: int, interval_us: int) -> None:
        """Turn by this angle, for an integer number of frames, because the command can change only at a frame."""
        frames = math.ceil(abs(angle_rad) / (self.max_turn_radps * interval_us * 1e-6))
        duration_us = frames * interval_us
        self._turn_until_us = now + duration_us
        self._turn = Twist(v_mps=0.0, omega_radps=angle_rad / (duration_us * 1e-6))
