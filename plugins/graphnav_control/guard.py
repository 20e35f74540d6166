"""The last stage before the motors: stops the robot on stale, blind or late inputs, and reports the cause."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from graphnav import Age, GuardState, Image, Latest, Plane, Stage, Stamp, Stop, Twist, param
from graphnav_control.causes import Cause, Staleness, contrast, judged_ratio, lost
from graphnav_control.limits import limited

STANDSTILL = Twist(v_mps=0.0, omega_radps=0.0)
REST_MPS = 1e-9
"""Speeds up to this are not forward: the cosine of a right angle is not exactly 0."""


class GuardOutputs(NamedTuple):
    """Outputs of `Guard`, published at every firing."""

    twist: Twist
    state: GuardState


class Guard(Stage):
    """Lets a command through to the motors while the robot sees, and stops it otherwise.

    The robot stands while a wired input among ``command``, ``plane`` and ``image`` has not arrived yet ("waiting"), is
    older than ``max_age_s`` ("stale", until for as long its age has stayed below 0.8 of that), or has implausible
    stamps or values that are not finite ("fault"). It also stands while too little of the plane could be judged or the
    image is blank ("blind"): unknown is not free. While nearly all judged cells are obstacle ("obstacle") it may turn
    and drive backward, but not forward. The same holds by default while more than ``max_unknown_ratio`` of the cells
    inside the picture's rim were not judged ("unknown", see `Plane.unknown`), as before a white wall; ``unjudged``
    chooses another reaction.

    A fresh ``override`` (teleoperation) replaces the command and is exempt from these rules; their causes are still
    published. When it ends, the command drives again. An override with implausible stamps stops the robot.

    An engaged ``stop`` message stops the robot, regardless of other inputs, until a fresh message that is not engaged
    re-arms the guard. An engaged message is obeyed at any age.

    To stop is to publish ``Twist(0, 0)`` at once: limits of acceleration apply when the robot speeds up, never when it
    slows down. Without limits a command that passes is unchanged, bit for bit. In a live graph give the stage a timer
    (``every_ms``), otherwise it does not notice that commands cease.
    """

    is_guard: ClassVar[bool] = True

    max_age_s: float = param(
        0.5, gt=0.0, le=10.0, doc="age beyond which command, plane or image stops the robot: a few of their periods"
    )
    min_judged_ratio: float = param(
        0.5,
        ge=0.0,
        le=1.0,
        doc="minimum share of judged cells of the plane for the robot to move; flow is never valid at the border of "
        "the picture, which leaves 0.77 and more in the drives of the shipped graphs except `white_wall`; 0 moves "
        "blind, with ``unjudged: ignore``",
    )
    max_obstacle_ratio: float = param(
        0.9,
        ge=0.0,
        le=1.0,
        doc="share of obstacle among the judged cells above which the robot may not go forward: from 0.9 on steer.pca "
        "finds no free direction either and does not drive forward; 1 sets no limit",
    )
    unjudged: Literal["obstacle", "hold", "brake", "ignore"] = param(
        "obstacle",
        doc="reaction to more unknown cells than max_unknown_ratio: obstacle lets the robot turn and drive backward, "
        "hold stops it, brake reduces its forward speed, ignore takes them for free floor",
    )
    max_unknown_ratio: float = param(
        0.1,
        ge=0.0,
        le=1.0,
        doc="share of unknown cells among the cells inside the rim above which ``unjudged`` applies; in the drives of "
        "the shipped graphs except `white_wall` it is 0; 1 sets no limit",
    )
    rim_ratio: float = param(
        Plane.RIM_RATIO,
        ge=0.0,
        le=0.4,
        doc="width of the rim, a share of the picture's shorter side, in which a cell that was not judged is not "
        "unknown: flow is never valid there",
    )
    unknown_speed_ratio: float = param(0.3, ge=0.0, le=1.0, doc="share of the forward speed that brake leaves")
    min_contrast_gray: float = param(
        3.0,
        ge=0.0,
        le=1e6,
        doc="standard deviation of the image, averaged over blocks, below which it counts as blank (a covered lens, a "
        "white picture), whatever a detector judges; the shipped worlds have 14 and more; 0 sets no limit",
        renamed_from="min_contrast",
    )
    override_max_age_s: float = param(0.3, gt=0.0, le=5.0, doc="age beyond which an override ends")
    max_speed_mps: float | None = param(
        None, ge=0.0, le=1000.0, doc="maximum speed, forward and backward; null for no limit"
    )
    max_turn_radps: float | None = param(None, ge=0.0, le=1000.0, doc="maximum turning rate; null for no limit")
    max_accel_mps2: float | None = param(None, gt=0.0, le=1e6, doc="maximum acceleration; null for no limit")
    max_turn_accel_radps2: float | None = param(
        None, gt=0.0, le=1e6, doc="maximum angular acceleration; null for no limit"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Stand, armed."""
        self._is_stopped = False
        self._staleness = {port: Staleness() for port in ("command", "plane", "image")}
        self._turnable = {"obstacle"} if self.unjudged == "hold" else {"obstacle", "unknown"}
        self._passable = {"unknown"} if self.unjudged == "brake" else set[str]()
        self._last = STANDSTILL
        self._begin: int | None = None
        self._before = 0
        # Of the last plane and the last image: the guard fires more often than they come.
        self._seen: tuple[Plane | None, float, float] = None, 0.0, 0.0
        self._contrast: tuple[Image | None, float] = None, 0.0

    def step(
        self,
        command: Twist | None,
        plane: Latest[Plane],
        image: Latest[Image],
        override: Latest[Twist],
        stop: Latest[Stop],
        utime: Stamp,
        command_age_s: Age,
    ) -> GuardOutputs:
        """Return the command for the motors, and the causes that restrict it."""
        if self._begin is None:
            self._begin = self._before = utime
        waited_s = (utime - self._begin) * 1e-6
        causes = [
            *self._lost("command", Latest(command, command_age_s), waited_s),
            *self._of_plane(plane, waited_s),
            *self._of_image(image, waited_s),
        ]
        driver, stops = self._driver(override)
        stops += self._of_stop(stop)
        active = set() if driver is not None else {cause.name for cause in causes}
        may_move = not stops and active <= self._turnable
        may_advance = may_move and active <= self._passable
        wanted = command if driver is None else driver
        if wanted is None or not may_move:
            wanted = STANDSTILL
        elif active and wanted.v_mps > REST_MPS:
            kept = self.unknown_speed_ratio if may_advance else 0.0
            wanted = Twist(v_mps=kept * wanted.v_mps, omega_radps=wanted.omega_radps)
        self._last = self._limited(wanted, min(max(utime - self._before, 0) * 1e-6, self.max_age_s))
        self._before = utime
        causes = stops + causes
        return GuardOutputs(
            self._last,
            GuardState(
                may_move=may_move,
                may_advance=may_advance,
                overridden=driver is not None and not stops,
                stopped=self._is_stopped,
                causes=tuple(cause.name for cause in causes),
                ports=tuple(cause.port for cause in causes),
                values=np.array([cause.value for cause in causes]),
                limits=np.array([cause.limit for cause in causes]),
            ),
        )

    def _lost(self, port: str, input: Latest[Any], waited_s: float) -> list[Cause]:  # noqa: A002
        return lost(port, input, self._staleness[port], self.max_age_s, waited_s)

    def _of_plane(self, plane: Latest[Plane], waited_s: float) -> list[Cause]:
        causes = self._lost("plane", plane, waited_s)
        if causes or plane.value is None:
            return causes
        if self._seen[0] is not plane.value:
            self._seen = plane.value, judged_ratio(plane.value), plane.value.unknown_ratio(self.rim_ratio)
        _, judged, unknown = self._seen
        if judged < self.min_judged_ratio:
            causes.append(Cause("blind", "plane", judged, self.min_judged_ratio))
        if self.unjudged != "ignore" and unknown > self.max_unknown_ratio:
            causes.append(Cause("unknown", "plane", unknown, self.max_unknown_ratio))
        if plane.value.obstacle_ratio > self.max_obstacle_ratio:
            causes.append(Cause("obstacle", "plane", plane.value.obstacle_ratio, self.max_obstacle_ratio))
        return causes

    def _of_image(self, image: Latest[Image], waited_s: float) -> list[Cause]:
        causes = self._lost("image", image, waited_s)
        if causes or image.value is None:
            return causes
        if self._contrast[0] is not image.value:
            self._contrast = image.value, contrast(image.value)
        seen = self._contrast[1]
        return [Cause("blind", "image", seen, self.min_contrast_gray)] if seen < self.min_contrast_gray else []

    def _of_stop(self, stop: Latest[Stop]) -> list[Cause]:
        """Handle the newest stop message; return the cause while it is engaged."""
        if stop.value is not None:
            if stop.value.engaged:
                self._is_stopped = True
            elif stop.age_s <= self.max_age_s and not stop.fault:
                self._is_stopped = False
        return [Cause("stop", "stop")] if self._is_stopped else []

    def _driver(self, override: Latest[Twist]) -> tuple[Twist | None, list[Cause]]:
        """Return the active override, if any, and the cause that forbids a fresh one."""
        if override.value is None or override.age_s > self.override_max_age_s:
            return None, []
        if override.fault or override.value.not_finite():
            return None, [Cause("fault", "override")]
        return override.value, []

    def _limited(self, wanted: Twist, elapsed_s: float) -> Twist:
        return Twist(
            v_mps=limited(wanted.v_mps, self._last.v_mps, self.max_speed_mps, self.max_accel_mps2, elapsed_s),
            omega_radps=limited(
                wanted.omega_radps,
                self._last.omega_radps,
                self.max_turn_radps,
                self.max_turn_accel_radps2,
                elapsed_s,
            ),
        )
