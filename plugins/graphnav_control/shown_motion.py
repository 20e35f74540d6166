"""Whether the picture moves as the robot does: the flow that it shows, against the flow of the floor."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np

from graphnav import Flow, Latest, Motion, Mount, Twist, coarsen
from graphnav.arrays import Bools, Floats

PREDICTED_RATIO = 3.0
"""The picture is judged once the floor flows by this many times ``frozen_px``."""
MIN_STILL = 3
"""Flows, or sums of flows, without motion before the picture counts as frozen."""
SETTLE_US = 500_000
"""Time within which a base does what it was told."""
MAX_SUM_US = 2_000_000
"""Longest time over which flows are summed: a slower motion is a creep that is not judged."""
MAX_CELLS = 48
"""Flows are judged on a grid of at most as many columns."""
MIN_CELLS = 12
"""With fewer valid cells a flow shows nothing."""


class Sent(NamedTuple):
    """A command that the guard sent."""

    utime: int
    twist: Twist


class SentCommands:
    """Recent commands of the guard, and the slowest motion that the robot can have made by them."""

    def __init__(self) -> None:
        self._sent: deque[Sent] = deque()

    def add(self, utime: int, twist: Twist) -> None:
        """Add a command; those before the ones that can still be asked for are dropped."""
        if self._sent and utime < self._sent[-1].utime:
            self._sent.clear()
        self._sent.append(Sent(utime, twist))
        while len(self._sent) > 2 and self._sent[1].utime <= utime - SETTLE_US - MAX_SUM_US:
            self._sent.popleft()

    def moved(self, begin: int) -> bool:
        """Return whether any command since ``begin`` moved the robot."""
        return any(twist.v_mps or twist.omega_radps for twist in self._since(begin))

    def slowest(self, begin: int) -> Twist:
        """Return the slowest speed and turning rate since ``begin``, 0 where it changed its sign or is not known."""
        if not self._sent or self._sent[0].utime > begin:
            return Twist(v_mps=0.0, omega_radps=0.0)
        twists = self._since(begin)
        return Twist(
            v_mps=_slowest([twist.v_mps for twist in twists]),
            omega_radps=_slowest([twist.omega_radps for twist in twists]),
        )

    def _since(self, begin: int) -> list[Twist]:
        """Return the commands that held at ``begin`` or later."""
        ends = [one.utime for one in self._sent][1:]
        last = [one.twist for one in self._sent][-1:]
        return [one.twist for one, end in zip(self._sent, ends, strict=False) if end > begin] + last


def _slowest(speeds: list[float]) -> float:
    return max(min(speeds), 0.0) + min(max(speeds), 0.0)


class ShownMotion:
    """Judges distinct flows, one after the other, by the motion that odometry or the commands predict.

    A flow is still if the median length of its valid vectors is below ``frozen_px`` where the floor would have
    flowed by three times as much; flows of slower motions are added up until it would have. The picture is frozen
    after `MIN_STILL` of these, together of at least ``frozen_s``, without one that moved in between. ``moved`` counts
    those; `restart` forgets the evidence. ``shown_px`` is the length of the last flow that was still.
    """

    def __init__(self, mount: Mount, frozen_px: float, frozen_s: float) -> None:
        self._mount, self._frozen_px, self._frozen_us = mount, frozen_px, frozen_s * 1e6
        self.shown_px = 0.0
        self._flow: Flow | None = None
        self._valid: Bools | None = None
        self._shown: Floats
        self._predicted: Floats
        self._us: int
        self.restart()

    def restart(self) -> None:
        """Forget the evidence."""
        self.moved = 0
        self._n_still = self._still_us = 0
        self._begin_sum()

    @property
    def is_frozen(self) -> bool:
        """Whether the evidence is complete."""
        return self._n_still >= MIN_STILL and self._still_us >= self._frozen_us

    def see(self, utime: int, flow: Latest[Flow], motion: Latest[Motion], sent: SentCommands, max_age_s: float) -> None:
        """Judge the newest flow, if it is a new one; a motion that is not fresh is not used."""
        if flow.value is None or flow.value is self._flow or flow.fault or flow.value.not_finite():
            return
        if self._flow is not None and self._flow.valid.shape != flow.value.valid.shape:
            self._begin_sum()
        self._flow = flow.value
        begin = utime - round(flow.age_s * 1e6) - flow.value.interval_us - SETTLE_US
        predicted = _motion(flow.value, sent.slowest(begin))
        if motion.value is not None and motion.age_s <= max_age_s and not (motion.fault or motion.value.not_finite()):
            predicted = _scaled(motion.value, flow.value.interval_us)
        self._judge(flow.value, predicted, is_driven=sent.moved(begin))

    def _judge(self, flow: Flow, predicted: Motion, *, is_driven: bool) -> None:
        factor = max(-(-flow.valid.shape[1] // MAX_CELLS), 1)
        cells = coarsen(flow, flow.step_px * factor)
        valid = cells.valid.reshape(-1) != 0
        if self._valid is not None:
            valid = valid & self._valid
        if np.count_nonzero(valid) < MIN_CELLS:
            self._begin_sum()
            return
        self._valid, self._us = valid, self._us + flow.interval_us
        self._shown = self._shown + cells.uv_px.reshape(-1, 2)
        shown_px = _median_px(self._shown, valid)
        if shown_px >= self._frozen_px:
            self.moved += 1
            self._n_still = self._still_us = 0
            self._begin_sum()
            return
        if not is_driven:
            self._begin_sum()
            return
        self._predicted = self._predicted + self._mount.floor_moved_px(cells, predicted).astype(np.float32)
        if _median_px(self._predicted, valid) >= PREDICTED_RATIO * self._frozen_px:
            self._n_still += 1
            self._still_us += self._us
            self.shown_px = shown_px
            self._begin_sum()
        elif self._us > MAX_SUM_US:
            self._begin_sum()

    def _begin_sum(self) -> None:
        self._valid = None
        self._shown = np.zeros((1, 2), np.float32)
        self._predicted = np.zeros((1, 2), np.float32)
        self._us = 0


def _median_px(vectors: Floats, valid: Bools) -> float:
    return float(np.median(np.hypot(vectors[valid, 0], vectors[valid, 1])))


def _motion(flow: Flow, speed: Twist) -> Motion:
    seconds = flow.interval_us * 1e-6
    return Motion(
        forward_m=speed.v_mps * seconds,
        left_m=0.0,
        turn_rad=speed.omega_radps * seconds,
        interval_us=flow.interval_us,
    )


def _scaled(motion: Motion, interval_us: int) -> Motion:
    """Return a motion of the same speeds over another interval."""
    share = interval_us / max(motion.interval_us, 1)
    return Motion(
        forward_m=share * motion.forward_m,
        left_m=share * motion.left_m,
        turn_rad=share * motion.turn_rad,
        interval_us=interval_us,
    )
