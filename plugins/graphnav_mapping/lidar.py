"""Map of the floor around the robot, from the scans of a lidar."""

from __future__ import annotations

import math

import cv2
import numpy as np

from graphnav import Continuity, LocalMap, Motion, ParamError, Scan, Stage, Stamp, param
from graphnav.arrays import Bools, Bytes, Doubles, Indices
from graphnav_mapping.local import distance_m
from graphnav_mapping.rolling_grid import RollingGrid

_MIN_CELLS, _MAX_CELLS = 8, 2000
_OBSTACLE, _FREE = 1.0, -1.0


class Lidar(Stage):
    """Map of what is free, obstacle or unknown around the robot; it remembers what the lidar sees no more.

    As the obstacle layer of [CM]: what a beam hits within ``mark_m`` makes its cell an obstacle, and the cells that a
    beam passes through within ``clear_m`` become free. The last scan that saw a cell decides. A cell is passed through
    if the beam next to its middle reaches beyond it and no beam ends in it. The map moves under the robot by the motion
    of odometry; errors of odometry smear what is out of view. Nothing is known to move.

    References
    ----------
    .. [CM] D. V. Lu, D. Hershberger, W. D. Smart, Layered Costmaps for Context-Sensitive Navigation, IROS 2014.
    """

    size_m: float = param(8.0, gt=0.0, le=100.0, doc="side of the map")
    cell_m: float = param(0.05, ge=0.001, le=1.0, doc="side of a cell")
    mark_m: float = param(
        2.5, gt=0.0, le=1000.0, doc="distance up to which what a beam hits is marked (obstacle_range of [CM])"
    )
    clear_m: float = param(
        3.0, gt=0.0, le=1000.0, doc="distance up to which a beam frees what it passes through (raytrace_range of [CM])"
    )
    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body; the floor below it is free")

    def check(self) -> None:
        """Check that the grid is neither too coarse nor too fine for its size."""
        cells = self._cells()
        if not _MIN_CELLS <= cells <= _MAX_CELLS:
            what = f"'size_m' {self.size_m:g} and 'cell_m' {self.cell_m:g} give a map of {cells} cells to a side"
            raise ParamError("size_m", what, f"choose them for {_MIN_CELLS} to {_MAX_CELLS} cells")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Know nothing."""
        self._continuity = Continuity()
        self._start()

    def step(self, scan: Scan, motion: Motion, stamp: Stamp) -> LocalMap:
        """Return the map with this scan.

        It restarts after a gap of more than 3 periods, and where the motion is longer than half of the map: odometry
        that jumps does not tell where the robot is on it.
        """
        if self._continuity.breaks(stamp):
            self._start()
        if math.hypot(motion.forward_m, motion.left_m) > self.size_m / 2:
            self._start()
            motion = Motion(forward_m=0.0, left_m=0.0, turn_rad=0.0, interval_us=motion.interval_us)
        grid = self._grid
        grid.move(motion.forward_m, motion.left_m, motion.turn_rad)
        grid.evidence[self._passed(scan)] = _FREE
        below = np.zeros(grid.evidence.shape, np.uint8)
        cv2.circle(below, grid.cell(), math.ceil(self.robot_radius_m / grid.cell_m), 1, cv2.FILLED)
        grid.evidence[below != 0] = _FREE
        grid.evidence[self._hit(scan)] = _OBSTACLE
        return self._map()

    def _start(self) -> None:
        self._grid = RollingGrid(self._cells(), self.cell_m)

    def _cells(self) -> int:
        """Return the number of cells to a side."""
        return math.ceil(self.size_m / self.cell_m)

    def _passed(self, scan: Scan) -> Bools:
        """Return the cells whose middle the next beam passes within ``clear_m``, (rows, cols)."""
        grid = self._grid
        at_m = grid.cell_m * np.arange(len(grid.evidence))
        x_m = (grid.origin_x_m - grid.x_m + at_m)[None, :].astype(np.float32)
        y_m = (grid.origin_y_m - grid.y_m + at_m)[:, None].astype(np.float32)
        away_m = np.hypot(x_m, y_m)
        bearing_rad = np.arctan2(y_m, x_m) - np.float32(grid.yaw_rad)
        reach_m = np.minimum(scan.free_m(), self.clear_m) - grid.cell_m / 2
        beam = _nearest_beam(scan, bearing_rad.astype(np.float64))
        return np.asarray((beam >= 0) & (away_m <= reach_m[beam]))

    def _hit(self, scan: Scan) -> tuple[Indices, Indices]:
        """Return the rows and columns of the cells in which beams end within ``mark_m``, one for each such beam."""
        points_m = scan.points_m()
        points_m = points_m[np.hypot(*points_m.T) <= self.mark_m]
        grid = self._grid
        c, s = math.cos(grid.yaw_rad), math.sin(grid.yaw_rad)
        turned = points_m @ np.array([[c, s], [-s, c]]) + (grid.x_m - grid.origin_x_m, grid.y_m - grid.origin_y_m)
        cols, rows = np.rint(turned / grid.cell_m).astype(np.intp).T
        size = len(grid.evidence)
        inside = (rows >= 0) & (rows < size) & (cols >= 0) & (cols < size)
        return rows[inside], cols[inside]

    def _map(self) -> LocalMap:
        grid = self._grid
        state: Bytes = np.full(grid.evidence.shape, LocalMap.UNKNOWN, np.uint8)
        state[grid.evidence == _FREE] = LocalMap.FREE
        state[grid.evidence == _OBSTACLE] = LocalMap.OBSTACLE
        return LocalMap(
            cell_m=grid.cell_m,
            origin_x_m=grid.origin_x_m,
            origin_y_m=grid.origin_y_m,
            x_m=grid.x_m,
            y_m=grid.y_m,
            yaw_rad=grid.yaw_rad,
            state=state,
            obstacle_m=distance_m(state == LocalMap.OBSTACLE, grid.cell_m),
            unknown_m=distance_m(state == LocalMap.UNKNOWN, grid.cell_m),
        )


def _nearest_beam(scan: Scan, bearing_rad: Doubles) -> Indices:
    """Return the beam that is nearest to each direction, -1 where none is within half of the angle between two."""
    step_rad, count = scan.angle_increment_rad, len(scan.ranges_m)
    around = 2 * math.pi / abs(step_rad)
    beam = np.remainder((bearing_rad - scan.angle_min_rad) / step_rad + 0.5, around).astype(np.intp)
    return np.where(beam < count, beam, -1)
