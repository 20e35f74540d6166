"""The dynamic window: the speeds that a robot can have after a short time."""

from __future__ import annotations

from graphnav import Motion


def measured_speeds(motion: Motion | None) -> tuple[float, float]:
    """Return forward speed and turning rate of the last interval, standstill without one."""
    if motion is None or motion.interval_us <= 0:
        return 0.0, 0.0
    per_s = 1e6 / motion.interval_us
    return motion.forward_m * per_s, motion.turn_rad * per_s


def window(now: float, change: float, low: float, high: float) -> tuple[float, float]:
    """Return the lowest and the highest speed within ``change`` of ``now`` and from ``low`` to ``high``.

    A speed outside of these limits counts as the nearest one inside.
    """
    return min(max(now - change, low), high), max(min(now + change, high), low)
