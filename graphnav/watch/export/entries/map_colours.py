"""The colours of maps, as in the pictures of a run, except the robot: red, green, blue from 0 to 1."""

from __future__ import annotations

WALL = (0.30, 0.34, 0.42)
OBSTACLE = (0.79, 0.54, 0.29)
MOVING = (0.56, 0.42, 0.70)
GOAL = (0.35, 0.64, 0.41)
ROBOT = (1.0, 0.70, 0.15)
"""Visible on dark and light backgrounds."""
SEEN = (0.16, 0.62, 0.96)

BODIES = {0: WALL, 1: OBSTACLE, 2: MOVING}
"""By the kind of a body in `Map`."""
MOVES = 2
"""The kind of moving bodies."""
