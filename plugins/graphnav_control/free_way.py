"""How far a robot can drive straight on by a local map, and how fast it may then be."""

from __future__ import annotations

import math

import numpy as np

from graphnav import LocalMap

TOLERANCE_M = 0.005
"""How much nearer to what touches it already the robot may come."""


def free_way_m(map: LocalMap, radius_m: float, sign: float = 1.0) -> float:  # noqa: A002  # the port's name
    """Return how far a disc of ``radius_m`` drives straight on before it meets an obstacle or unknown floor, metres.

    ``sign``: 1 forward, -1 backward.

    Where the disc is in touch already, only a nearer touch ends the way.
    """
    steps_m = map.cell_m / 2 * np.arange(max(map.state.shape))
    aside_m = np.zeros_like(steps_m)
    near_m, unknown_m = map.obstacle_m_at(sign * steps_m, aside_m), map.unknown_m_at(sign * steps_m, aside_m)
    blocked = near_m < min(radius_m, float(near_m[0]) - TOLERANCE_M)
    blocked |= unknown_m <= 0.0
    return float(steps_m[max(int(np.argmax(blocked)) - 1, 0)]) if blocked.any() else float(steps_m[-1])


def kept_m(map: LocalMap, theta_rad: float, way_m: float) -> float:  # noqa: A002  # the port's name
    """Return how far from obstacles the robot stays on a straight way at ``theta_rad`` from forward, metres."""
    steps_m = map.cell_m / 2 * np.arange(math.ceil(2 * way_m / map.cell_m) + 1)
    forward_m, left_m = np.multiply.outer([math.cos(theta_rad), math.sin(theta_rad)], steps_m)
    return float(map.obstacle_m_at(forward_m, left_m).min())


def safe_speed_mps(way_m: float, max_decel_mps2: float, reaction_s: float) -> float:
    """Return the speed from which a robot that reacts after ``reaction_s`` stops within ``way_m``, m/s."""
    waste_mps = max_decel_mps2 * reaction_s
    return max(0.0, math.sqrt(waste_mps**2 + 2 * max_decel_mps2 * max(way_m, 0.0)) - waste_mps)
