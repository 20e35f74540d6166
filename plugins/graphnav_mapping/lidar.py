"""Map of the floor around the robot, from the scans of a lidar."""

from __future__ import annotations

import math

import numpy as np

from graphnav import Continuity, LocalMap, Motion, Scan, Stage, Stamp, param
from graphnav.arrays import Bools, Bytes, Doubles, Indices
from graphnav_mapping.rolling_grid import RollingGrid, without_jump

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
        RollingGrid.check(self.size_m, self.cell_m)

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Know nothing."""
        self._continuity = Continuity()
        self._start()

    def step(self, scan: Scan, motion: Motion, stamp: Stamp) -> LocalMap:
        """Return the map with this scan.

        It restarts after a gap of more than 3 periods, and where the motion is longer than half of the map: odometry
        that jumps does not tell where the robot is on it.
        """
        usable = without_jump(motion, self.size_m)
        if self._continuity.breaks(stamp) or usable is not motion:
            self._start()
        grid = self._grid
        grid.move(usable)
        grid.evidence[self._passed(scan)] = _FREE
        grid.stand(self.robot_radius_m, _FREE)
        grid.evidence[self._hit(scan)] = _OBSTACLE
        state: Bytes = np.full(grid.evidence.shape, LocalMap.UNKNOWN, np.uint8)
        state[grid.evidence == _FREE] = LocalMap.FREE
        state[grid.evidence == _OBSTACLE] = LocalMap.OBSTACLE
        return grid.to_map(state)

    def _start(self) -> None:
        self._grid = RollingGrid(self.size_m, self.cell_m)

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


def _nearest_beam(scan: Scan, bearing_rad: Doubles) -> Indices:
    """Return the beam that is nearest to each direction, -1 where none is within half of the angle between two."""
    step_rad, count = scan.angle_increment_rad, len(scan.ranges_m)
    around = 2 * math.pi / abs(step_rad)
    beam = np.remainder((bearing_rad - scan.angle_min_rad) / step_rad + 0.5, around).astype(np.intp)
    return np.where(beam < count, beam, -1)
