"""The frames of a log nearest to given times."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence

from graphnav import Flow, Image, Plane, UserError
from graphnav_view.signals import Signals

_OUTSIDE_S = 0.5
"""A time this far before the first frame or after the last is still taken for that frame."""


def frame_stamps(signals: Signals) -> list[int]:
    """Return the stamps (microseconds) of all that a camera saw or that was made of it, ascending."""
    return sorted({utime for kind in (Image, Flow, Plane) for utime in signals.stamps(kind)})


def frame_utime(signals: Signals, stamps: Sequence[int], time_s: float) -> int:
    """Return the stamp nearest to a time, seconds from the start of the log.

    Raises
    ------
    UserError
        The time is not within the frames.
    """
    first_s, last_s = signals.at_s(stamps[0]), signals.at_s(stamps[-1])
    if not first_s - _OUTSIDE_S <= time_s <= last_s + _OUTSIDE_S:
        raise UserError.of(
            f"there is no frame at {time_s:g} s", f"the log has frames from {first_s:.2f} s to {last_s:.2f} s"
        )
    return nearest(stamps, round(signals.begin_us + time_s * 1e6))


def nearest(stamps: Sequence[int], utime: int) -> int:
    """Return the stamp nearest to another one, the earlier of two that are as near; ``stamps`` ascend."""
    place = bisect_left(stamps, utime)
    return min(stamps[max(0, place - 1) : place + 1], key=lambda stamp: abs(stamp - utime))
