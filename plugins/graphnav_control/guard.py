"""The last stage before the motors: stops the robot on stale, blind or late inputs, and reports the cause."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from graphnav import (
    Age,
    Flow,
    FlowDeviation,
    GuardState,
    Image,
    Latest,
    Motion,
    Mount,
    Odometry,
    OdometryCheck,
    Plane,
    Stage,
    Stamp,
    Stop,
    Twist,
    Unnoticed,
    param,
)
from graphnav_control.causes import Cause, Staleness, contrast, judged_ratio, lost
from graphnav_control.latch import Latch, Relapses
from graphnav_control.limits import limited
from graphnav_control.shown_motion import SETTLE_US, SentCommands, ShownMotion

STANDSTILL = Twist(v_mps=0.0, omega_radps=0.0)
REST_MPS = 1e-9
"""Speeds up to this are not forward: the cosine of a right angle is not exactly 0."""
MIN_MOVED = 2
"""Flows that move before a picture that was frozen is trusted again."""
INPUTS = ("command", "plane", "image", "flow", "deviation", "odometry")
"""Those that the robot stands without, once they are wired."""
WITHHELD_S = 0.1
"""Beyond ``max_age_s``, how long the motors may have taken nothing before the run withholds the commands."""
REPEAT_US = 1_000_000
"""A message that arms the guard is one order with those that came less than this before: a heartbeat is not many."""


class GuardOutputs(NamedTuple):
    """Outputs of `Guard`, published at every firing."""

    twist: Twist
    state: GuardState


class Guard(Stage):
    """Lets a command through to the motors while the robot sees, and stops it otherwise.

    The robot stands while a wired input among ``command``, ``plane``, ``image``, ``flow``, ``deviation`` and
    ``odometry`` has not arrived yet ("waiting"), is older than ``max_age_s`` ("stale", until for as long its age has
    stayed below 0.8 of that), or has implausible stamps or values that are not finite ("fault"). It also stands while
    too little of the plane could be judged or the image is blank ("blind"): unknown is not free; and while too little
    of the flow is known well ("confused") and a second longer, as on a floor that repeats and is driven over too fast
    to tell by how much it moves; after the fourth time in 20 s until it is armed or an operator has driven. While
    nearly all judged cells are obstacle ("obstacle") it may turn and drive backward, but not forward. The same holds by
    default while more than ``max_unknown_ratio`` of the cells inside the picture's rim were not judged ("unknown", see
    `Plane.unknown`), as before a white wall; ``unjudged`` chooses another reaction.

    It stands where the picture does not move although the robot does ("frozen"): a camera that repeats its picture, a
    covered lens, wheels that spin. That is, for ``frozen_s`` and at least three flows, the median length of the valid
    ``flow`` is below ``frozen_px`` where three times as much is predicted: by ``motion``, which has to come from
    odometry, else by the commands that the guard sent, which a base follows within half a second. Flows of slow motions
    are added up. Odometry that stands as the picture does, against commands of 0.1 m and more in 2 s, is not believed.
    A command that is withheld, as live where motors take nothing, is not evidence: what was sent since they took the
    last one counts as standstill, and the judgement starts again. A picture that only repeats is not frozen, since a
    robot that stands sees the same picture; a plane is not fresh evidence, since it is made of the same picture. And it
    stands where ``odometry``, as `odometry.motion` checks it, contradicts the picture ("jump", "turn_jump",
    "motionless", "reversed", "scale").

    Both hold the robot beyond the evidence, which is gone when it stands. After a second it retries once, slowly and
    ``retry_m`` at most, and drives on if the input now follows its motion. If not, or if odometry has not agreed with
    the picture since the start, it stands until the guard is armed (by a ``stop`` message that is not engaged) or the
    picture changes, which allows another such retry, five in all, or until an operator has driven it by ``override``
    and the input has followed.

    A fresh ``override`` (teleoperation) replaces the command and is exempt from these rules; their causes are still
    published. When it is older than ``override_max_age_s``, it has ended, and the command drives again. One that comes
    back within that time again is unreliable, and the driver must not alternate with the command: the robot stands
    ("stale") until the override is fresh as an input has to be, or nothing of it has come for twice that time. An
    override with implausible stamps stops the robot.

    An engaged ``stop`` message stops the robot, regardless of other inputs, until a fresh message that is not engaged
    re-arms the guard. An engaged message is obeyed at any age.

    To stop is to publish ``Twist(0, 0)`` at once: limits of acceleration apply when the robot speeds up, never when it
    slows down. Without limits a command that passes is unchanged, bit for bit. In a live graph give the stage a timer
    (``every_ms``), otherwise it does not notice that commands cease.
    """

    is_guard: ClassVar[bool] = True
    unnoticed = (
        Unnoticed("flow", (Image, Plane), "a picture that freezes"),
        Unnoticed("odometry", (Odometry,), "odometry that contradicts the picture"),
    )

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
    max_deviation_px: float = param(0.5, gt=0.0, le=100_000.0, doc="deviation of the flow up to which it is known well")
    min_known_ratio: float = param(
        0.5,
        ge=0.0,
        le=1.0,
        doc="minimum share of the picture inside the rim in which the flow is known well; 0 sets no limit",
    )
    min_contrast_gray: float = param(
        1.0,
        ge=0.0,
        le=1e6,
        doc="standard deviation of the image, averaged over blocks, below which it counts as blank (a covered lens, a "
        "white picture), whatever a detector judges; the shipped worlds have 14 and more, `suite/faint` 2.3; 0 sets no "
        "limit",
        renamed_from="min_contrast",
    )
    override_max_age_s: float = param(
        0.3, gt=0.0, le=5.0, doc="age beyond which an override ends; one that then returns at once is unreliable"
    )
    max_speed_mps: float | None = param(
        None, ge=0.0, le=1000.0, doc="maximum speed, forward and backward; null for no limit"
    )
    max_turn_radps: float | None = param(None, ge=0.0, le=1000.0, doc="maximum turning rate; null for no limit")
    max_accel_mps2: float | None = param(None, gt=0.0, le=1e6, doc="maximum acceleration; null for no limit")
    max_turn_accel_radps2: float | None = param(
        None, gt=0.0, le=1e6, doc="maximum angular acceleration; null for no limit"
    )

    frozen_px: float = param(
        0.1,
        ge=0.0,
        le=1000.0,
        doc="median length of the flow below which the picture does not move, where the robot's motion predicts three "
        "times as much; in the drives of the shipped graphs the flow of a robot that moves has 1 and more, that of one "
        "that stands 0.03 and less; 0 judges no flow",
    )
    frozen_s: float = param(0.4, gt=0.0, le=60.0, doc="time without motion in the flow after which it is frozen")
    retry_m: float = param(
        0.1,
        ge=0.0,
        le=10.0,
        doc="distance of the retry after a frozen picture or faulty odometry; 0 waits until an operator drives it",
    )
    camera_height_m: float = param(1.0, ge=0.01, le=100.0, doc=Mount.HEIGHT_DOC)
    tilt_deg: float = param(75.0, gt=0.0, le=90.0, doc=Mount.TILT_DOC)
    fov_deg: float = param(70.0, ge=5.0, le=150.0, doc=Mount.FOV_DOC)
    camera_forward_m: float = param(0.0, ge=-100.0, le=100.0, doc=Mount.FORWARD_DOC)

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Stand, armed."""
        self._is_stopped = False
        self._staleness = {port: Staleness() for port in INPUTS}
        self._turnable = {"obstacle"} if self.unjudged == "hold" else {"obstacle", "unknown"}
        self._passable = {"unknown"} if self.unjudged == "brake" else set[str]()
        self._last = STANDSTILL
        self._begin: int | None = None
        self._before = 0
        # Of the last plane and the last image: the guard fires more often than they come.
        self._seen: tuple[Plane | None, float, float] = None, 0.0, 0.0
        self._contrast: tuple[Image | None, float] = None, 0.0
        self._known: tuple[FlowDeviation | None, float] = None, 0.0
        self._confusion, self._confused = Relapses(), Cause("confused", "deviation")
        self._sent = SentCommands()
        mount = Mount(self.camera_height_m, self.tilt_deg, self.fov_deg, self.camera_forward_m)
        self._shown = ShownMotion(mount, self.frozen_px, self.frozen_s)
        self._picture, self._odometry = Latch(self.retry_m), Latch(self.retry_m)
        self._odometry_cause, self._has_agreed = Cause("", "odometry"), False
        self._order: tuple[Stop | None, int | None] = None, None
        self._was_driven = False
        self._override, self._has_returned = Staleness(), False

    def step(
        self,
        command: Twist | None,
        plane: Latest[Plane],
        image: Latest[Image],
        flow: Latest[Flow],
        deviation: Latest[FlowDeviation],
        motion: Latest[Motion],
        odometry: Latest[OdometryCheck],
        override: Latest[Twist],
        stop: Latest[Stop],
        utime: Stamp,
        command_age_s: Age,
    ) -> GuardOutputs:
        """Return the command for the motors, and the causes that restrict it."""
        if self._begin is None:
            self._begin = self._before = utime
        waited_s = (utime - self._begin) * 1e-6
        elapsed_s = min(max(utime - self._before, 0) * 1e-6, self.max_age_s)
        driver, stops = self._driver(override, waited_s)
        is_armed = self._obey(stop, utime)
        if self._is_stopped:
            stops.append(Cause("stop", "stop"))
        self._was_driven |= driver is not None
        retried_m = 0.0 if self._was_driven else abs(self._last.v_mps) * elapsed_s
        causes = [
            *self._lost("command", Latest(command, command_age_s), waited_s),
            *self._of_plane(plane, waited_s),
            *self._of_image(image, waited_s),
            *self._of_deviation(deviation, utime, waited_s, is_armed=is_armed),
            *self._of_flow(flow, motion, utime, waited_s, retried_m, is_armed=is_armed),
            *self._of_odometry(odometry, utime, waited_s, retried_m, is_armed=is_armed),
        ]
        may_move, may_advance, wanted = self._allowed(command if driver is None else driver, driver, stops, causes)
        self._last = self._limited(wanted, elapsed_s)
        self._before, self._was_driven = utime, driver is not None
        if command is None and driver is None:
            self._sent.withdraw(utime - round(1e6 * (self.max_age_s + WITHHELD_S)))
            self._shown.restart()
        self._sent.add(utime, self._last)
        causes = stops + causes
        is_latched = self._picture.is_latched or self._odometry.is_latched or self._confusion.is_latched
        return GuardOutputs(
            self._last,
            GuardState(
                may_move=may_move,
                may_advance=may_advance,
                overridden=driver is not None and not stops,
                stopped=self._is_stopped or (is_latched and driver is None),
                causes=tuple(cause.name for cause in causes),
                ports=tuple(cause.port for cause in causes),
                values=np.array([cause.value for cause in causes]),
                limits=np.array([cause.limit for cause in causes]),
            ),
        )

    def _allowed(
        self, wanted: Twist | None, driver: Twist | None, stops: list[Cause], causes: list[Cause]
    ) -> tuple[bool, bool, Twist]:
        """Return whether the robot may move, whether forward, and the command within that."""
        active = set() if driver is not None else {cause.name for cause in causes if not cause.is_retried}
        may_move = not stops and active <= self._turnable
        may_advance = may_move and active <= self._passable
        if wanted is None or not may_move:
            return may_move, may_advance, STANDSTILL
        if active and wanted.v_mps > REST_MPS:
            kept = self.unknown_speed_ratio if may_advance else 0.0
            wanted = Twist(v_mps=kept * wanted.v_mps, omega_radps=wanted.omega_radps)
        if driver is None and (self._picture.is_retrying or self._odometry.is_retrying):
            v_mps = limited(wanted.v_mps, 0.0, self._picture.speed_mps, None, 0.0)
            wanted = Twist(v_mps=v_mps, omega_radps=wanted.omega_radps)
        return may_move, may_advance, wanted

    def _lost(self, port: str, input: Latest[Any], waited_s: float) -> list[Cause]:  # noqa: A002
        return lost(port, input, self._staleness[port], self.max_age_s, waited_s)

    def _lost_late(self, port: str, input: Latest[Any], waited_s: float) -> list[Cause]:  # noqa: A002
        """Return what `_lost` does; what is made of two pictures is waited for, since it comes after the first one."""
        causes = self._lost(port, input, waited_s)
        return causes if waited_s > self.max_age_s else [cause for cause in causes if cause.name != "waiting"]

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

    def _of_deviation(
        self, deviation: Latest[FlowDeviation], utime: int, waited_s: float, *, is_armed: bool
    ) -> list[Cause]:
        """Judge whether enough of the flow is known; where it was not, the robot stands for longer."""
        causes = self._lost_late("deviation", deviation, waited_s)
        if causes or deviation.value is None:
            return causes
        if self._known[0] is not deviation.value:
            self._known = deviation.value, deviation.value.known_ratio(self.max_deviation_px, self.rim_ratio)
        known = self._known[1]
        is_confused = known < self.min_known_ratio
        if is_confused:
            self._confused = Cause("confused", "deviation", known, self.min_known_ratio)
        self._confusion.update(utime, is_faulty=is_confused, is_new=is_armed or self._was_driven)
        return [] if self._confusion.is_free else [self._confused]

    def _of_flow(
        self,
        flow: Latest[Flow],
        motion: Latest[Motion],
        utime: int,
        waited_s: float,
        retried_m: float,
        *,
        is_armed: bool,
    ) -> list[Cause]:
        """Judge whether the picture moves as the robot does."""
        if not flow.is_connected or not self.frozen_px:
            return []
        causes = self._lost_late("flow", flow, waited_s)
        if not causes:
            self._shown.see(utime, flow, motion, self._sent, self.max_age_s)
        moves = self._picture.is_retrying or self._was_driven
        found = Cause("frozen", "flow", self._shown.shown_px, self.frozen_px)
        is_frozen = self._shown.is_frozen
        if (
            self._picture.update(
                utime,
                retried_m,
                is_faulty=is_frozen,
                is_proven=moves and not is_frozen and self._shown.moved >= MIN_MOVED,
                is_new=is_armed or (self._shown.moved > 0 and not self._was_driven),
            )
            or is_frozen
        ):
            self._shown.restart()  # what was judged is not evidence again
        return causes + self._held(self._picture, found)

    def _of_odometry(
        self, odometry: Latest[OdometryCheck], utime: int, waited_s: float, retried_m: float, *, is_armed: bool
    ) -> list[Cause]:
        """Handle what the odometry's check found; it holds the robot beyond that if it was driving."""
        causes = self._lost_late("odometry", odometry, waited_s)
        check = odometry.value
        if check is None or causes:
            return causes
        if check.fault:
            self._odometry_cause = Cause(check.fault, "odometry", check.value, check.limit)
        agrees = check.agrees and not check.fault
        self._has_agreed |= agrees
        is_driven = self._sent.moved(utime - 2 * SETTLE_US, utime)
        self._odometry.update(
            utime,
            retried_m,
            is_faulty=bool(check.fault) and (is_driven or not self._odometry.is_free),
            is_proven=agrees,
            is_new=is_armed,
            is_known=self._has_agreed,
        )
        if check.fault and self._odometry.is_free:
            return [self._odometry_cause]
        return self._held(self._odometry, self._odometry_cause)

    @staticmethod
    def _held(latch: Latch, cause: Cause) -> list[Cause]:
        return [] if latch.is_free else [cause._replace(is_retried=latch.is_retrying)]

    def _obey(self, stop: Latest[Stop], utime: int) -> bool:
        """Handle the newest stop message; return whether it is a new order that arms the guard."""
        if stop.value is None:
            return False
        if stop.value.engaged:
            self._is_stopped = True
            self._order = stop.value, None
            return False
        if stop.age_s > self.max_age_s or stop.fault:
            return False
        self._is_stopped = False
        heard, armed = self._order
        if heard is stop.value:
            return False
        self._order = stop.value, utime
        return armed is None or utime - armed > REPEAT_US

    def _driver(self, override: Latest[Twist], now_s: float) -> tuple[Twist | None, list[Cause]]:
        """Return the active override, if any, and the causes that forbid one that comes."""
        max_age_s = self.override_max_age_s
        if override.value is None or override.age_s > 2 * max_age_s:
            self._override, self._has_returned = Staleness(), False
            return None, []
        is_fresh = override.age_s <= max_age_s
        if is_fresh and (override.fault or override.value.not_finite()):
            return None, [Cause("fault", "override")]
        causes = self._override.causes("override", override.age_s, max_age_s, now_s)
        self._has_returned = bool(causes) and (is_fresh or self._has_returned)
        if not causes:
            return override.value, []
        return None, causes if self._has_returned else []

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
