"""Whether the picture moves as the robot does: the flow that it shows, against the flow of the floor."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np

from graphnav import Flow, Latest, Motion, Mount, Twist, coarsen
from graphnav.arrays import Bools, Doubles, Floats

PREDICTED_RATIO = 3.0
"""The picture is judged once the floor flows by this many times ``frozen_px``."""
MIN_STILL = 3
"""Flows, or sums of flows, without motion before the picture counts as frozen."""
SETTLE_US = 500_000
"""Time within which a base does what it was told."""
_DELAYS_US = range(0, SETTLE_US + 1, SETTLE_US // 5)
MAX_SUM_US = 2_000_000
"""Longest time over which flows are summed: a slower motion is a creep that is not judged."""
MIN_TOLD_M = 0.1
"""Smallest way by the commands within that time which odometry may not deny together with the picture."""
MAX_CELLS = 48
"""Flows are judged on a grid of at most as many columns."""
MIN_CELLS = 12
"""With fewer valid cells a flow shows nothing."""


class Sent(NamedTuple):
    """A command that the guard sent."""

    utime: int
    twist: Twist


class SentCommands:
    """Recent commands of the guard, and the smallest motion that the robot can have made by them."""

    def __init__(self) -> None:
        self._sent: deque[Sent] = deque()

    def add(self, utime: int, twist: Twist) -> None:
        """Add a command; those before the ones that can still be asked for are dropped."""
        if self._sent and utime < self._sent[-1].utime:
            self._sent.clear()
        self._sent.append(Sent(utime, twist))
        while len(self._sent) > 2 and self._sent[1].utime <= utime - 2 * SETTLE_US - MAX_SUM_US:
            self._sent.popleft()

    def withdraw(self, since: int) -> None:
        """Count what was sent from a time on as standstill: the base did not get it."""
        while self._sent and self._sent[-1].utime >= since:
            self._sent.pop()
        self._sent.append(Sent(since, Twist(v_mps=0.0, omega_radps=0.0)))

    def moved(self, begin: int, end: int) -> bool:
        """Return whether any command that held within an interval moved the robot."""
        ends = [*(one.utime for one in self._sent), end][1:]
        return any(
            (one.twist.v_mps or one.twist.omega_radps) and until > begin and one.utime < end
            for one, until in zip(self._sent, ends, strict=True)
        )

    def smallest(self, begin: int, end: int) -> Motion:
        """Return the smallest way and turn within an interval of a base that does everything late, by 0 to `SETTLE_US`.

        Each is 0 where its sign depends on the delay. Short drives with stops in between, as of
        `control.stop_and_look`, add up.
        """
        moved = [self._moved(begin - delay_us, end - delay_us) for delay_us in _DELAYS_US]
        forward_m, turn_rad = (max(min(one), 0.0) + min(max(one), 0.0) for one in zip(*moved, strict=True))
        return Motion(forward_m=forward_m, left_m=0.0, turn_rad=turn_rad, interval_us=end - begin)

    def _moved(self, begin: int, end: int) -> tuple[float, float]:
        """Return what `smallest` does of a base without a delay; it stands before the first command."""
        forward_m = turn_rad = 0.0
        until = end
        for utime, twist in reversed(self._sent):
            seconds = max(until - max(utime, begin), 0) * 1e-6
            forward_m, turn_rad = forward_m + twist.v_mps * seconds, turn_rad + twist.omega_radps * seconds
            until = min(utime, until)
            if utime <= begin:
                break
        return forward_m, turn_rad


class ShownMotion:
    """Judges distinct flows, one after the other, by the motion that odometry or the commands predict.

    A flow is still if the median length of its valid vectors is below ``frozen_px`` where the floor would have
    flowed by three times as much; flows of slower motions are added up until it would have. The picture is frozen
    after `MIN_STILL` of these, together of at least ``frozen_s``, without one that moved in between; also where
    odometry has not moved either for `MAX_SUM_US`, against the commands: it may hang as the picture does. ``moved``
    counts the flows that moved; `restart` forgets the evidence. ``shown_px``: length of the last flow that was still.
    """

    def __init__(self, mount: Mount, frozen_px: float, frozen_s: float) -> None:
        self._mount, self._frozen_px, self._frozen_us = mount, frozen_px, frozen_s * 1e6
        self.shown_px = 0.0
        self._flow: Flow | None = None
        self._valid: Bools | None = None
        self._shown: Floats
        self._predicted: Doubles
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
        end = utime - round(flow.age_s * 1e6)
        is_fresh = motion.age_s <= max_age_s and not motion.fault
        measured = motion.value if is_fresh and motion.value is not None and not motion.value.not_finite() else None
        self._judge(flow.value, end, measured, sent)

    def _judge(self, flow: Flow, end: int, measured: Motion | None, sent: SentCommands) -> None:
        """Judge a flow up to ``end``, of our clock; ``measured``: by odometry."""
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
        begin = end - flow.interval_us - SETTLE_US
        is_first = measured is None and self._us == flow.interval_us
        if not sent.moved(begin, end) or (is_first and not sent.moved(begin - SETTLE_US, end - SETTLE_US)):
            self._begin_sum()  # the base stands, or need not have begun
            return
        if measured is not None:
            motion = _scaled(measured, flow.interval_us)
            self._predicted = self._predicted + self._mount.floor_moved_px(cells, motion)
        else:
            self._predicted = self._mount.floor_moved_px(cells, sent.smallest(end - self._us, end))
        if _median_px(self._predicted, valid) >= PREDICTED_RATIO * self._frozen_px:
            self._n_still += 1
            self._still_us += self._us
            self.shown_px = shown_px
            self._begin_sum()
        elif self._us > MAX_SUM_US:
            if abs(sent.smallest(end - self._us, end).forward_m) >= MIN_TOLD_M:
                self._n_still += MIN_STILL  # picture and odometry hang together, or the robot is blocked
                self._still_us += self._us
                self.shown_px = shown_px
            self._begin_sum()

    def _begin_sum(self) -> None:
        self._valid = None
        self._shown = np.zeros((1, 2), np.float32)
        self._predicted = np.zeros((1, 2))
        self._us = 0


def _median_px(vectors: Floats | Doubles, valid: Bools) -> float:
    """Return the median length; np.median takes several times as long for so few."""
    lengths = np.sort(np.hypot(vectors[valid, 0], vectors[valid, 1]))
    return float((lengths[(len(lengths) - 1) // 2] + lengths[len(lengths) // 2]) / 2)


def _scaled(motion: Motion, interval_us: int) -> Motion:
    """Return a motion of the same speeds over another interval."""
    share = interval_us / max(motion.interval_us, 1)
    return Motion(
        forward_m=share * motion.forward_m,
        left_m=share * motion.left_m,
        turn_rad=share * motion.turn_rad,
        interval_us=interval_us,
    )
