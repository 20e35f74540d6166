"""Map of the floor around the robot, from the planes of the frames."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Literal, TypeVar

import cv2
import numpy as np

from graphnav import (
    Continuity,
    FlowDeviation,
    Latest,
    LocalMap,
    Motion,
    Mount,
    ParamError,
    Plane,
    RecoveryState,
    Stage,
    Stamp,
    param,
)
from graphnav.arrays import Bools, Bytes, Doubles, Floats, Indices
from graphnav_mapping.movers import Look, Mover, Movers, swept
from graphnav_mapping.rolling_grid import GROUND, OBSTACLE, Box, RollingGrid, without_jump

Picture = TypeVar("Picture", Bytes, Floats)
_OBSTACLE_EVIDENCE = 1.0
_PRESUMED_FREE = -0.2
_FORGOTTEN = 0.5
"""Evidence of an obstacle that is forgotten: unknown, and an obstacle again if a full frame shows it."""
_NO_RECOVERY: Latest[RecoveryState] = Latest()
_BESIDE = np.ones((3, 3), np.uint8)
_LOOK_BACK_S = 0.8
"""How long ago the floor was seen that tells what moves."""
_RIMS = np.array([-0.6, 0.6])
"""Where a pixel ends, from its middle: a little farther than half a pixel, which the warp rounds."""
_FARTHEST = 100.0
_MAX_REACH = 100
"""Farthest shift, in cells, that is tried for what moves: the time grows with its square."""


class Local(Stage):
    """Map of what is free, obstacle or unknown around the robot; it remembers what has left the view.

    Every cell of the floor that the picture shows gains evidence from the plane: an obstacle's cell for, a ground
    cell against an obstacle. What the picture does not show keeps its evidence; the map moves under the robot by the
    motion of each frame. Cells that were never judged are unknown.

    An obstacle is placed where the lines of sight to its foot meet the floor. What is above the foot hides floor,
    which gains no evidence.

    Flow shows obstacles only to a robot that drives: evidence counts in proportion to the displacement, in full from
    ``full_motion_m`` on. Until the robot has driven ``presumed_m``, it presumes that unknown ground cells are free:
    it has to set out to see.

    Where ``deviation`` is wired, a cell whose flow is likely to be off by more than ``sure_px`` counts for less, by the
    square of their ratio.

    Where ``recovery`` is wired, obstacles that fewer full frames than its ``doubt`` have shown, less those that have
    shown floor there, are forgotten when a recovery begins: they are unknown until they are seen again, however small.
    """

    camera_height_m: float = param(1.0, ge=0.01, le=100.0, doc=Mount.HEIGHT_DOC)
    tilt_deg: float = param(75.0, gt=0.0, le=90.0, doc=Mount.TILT_DOC)
    fov_deg: float = param(70.0, ge=5.0, le=150.0, doc=Mount.FOV_DOC)
    camera_forward_m: float = param(0.0, ge=-100.0, le=100.0, doc=Mount.FORWARD_DOC)
    size_m: float = param(9.0, gt=0.0, le=100.0, doc="side of the map")
    cell_m: float = param(0.04, ge=0.001, le=1.0, doc="side of a cell")
    max_distance_m: float = param(
        2.0, gt=0.0, le=1000.0, doc="distance from the camera's foot beyond which the plane is not used"
    )
    hit: float = param(
        0.8, gt=0.0, le=1000.0, doc="dimensionless: evidence of a frame for an obstacle; from 1 on it is one"
    )
    miss: float = param(0.4, gt=0.0, le=1000.0, doc="dimensionless: evidence of a frame against an obstacle")
    max_evidence: float = param(
        3.0, ge=1.0, le=1000.0, doc="dimensionless: evidence for an obstacle that more frames do not add to"
    )
    max_free_evidence: float = param(
        1.0,
        gt=0.0,
        le=1000.0,
        doc="dimensionless: evidence against an obstacle that more frames do not add to; less reacts sooner",
    )
    ahead_s: float = param(
        3.0,
        ge=0.0,
        le=60.0,
        doc="time for which moving obstacles are expected to go on, which blocks that floor; 0: none",
    )
    min_mover_mps: float = param(0.06, gt=0.0, le=1000.0, doc="speed from which an obstacle counts as moving")
    max_mover_mps: float = param(0.6, gt=0.0, le=5.0, doc="fastest obstacle that is followed")
    full_motion_m: float = param(
        0.02, gt=0.0, le=100_000.0, doc="displacement of a frame from which its evidence counts in full"
    )
    blind_height_m: float = param(
        0.05,
        ge=0.0,
        le=100.0,
        doc="height up to which an obstacle moves too much like the floor to be seen: obstacles reach down by this "
        "much from where they are seen",
    )
    foot_m: float = param(
        0.15,
        gt=0.0,
        le=100.0,
        doc="depth of the floor that an obstacle marks from its foot on; floor that it hides stays unknown",
    )
    min_unknown_m2: float = param(0.02, ge=0.0, le=1e6, doc="unknown floor of a smaller area counts as free")
    sure_px: float = param(
        0.1, gt=0.0, le=100_000.0, doc="deviation of the flow up to which the judgement of a cell counts in full"
    )
    presumed_m: float = param(
        0.15, ge=0.0, le=100_000.0, doc="distance from the start up to which ground is free until it is judged"
    )
    unjudged: Literal["obstacle", "unknown"] = param(
        "obstacle",
        doc="meaning of cells in view that cannot be judged, such as a wall without texture; unknown waits for better "
        "views",
    )
    rim_ratio: float = param(
        Plane.RIM_RATIO, ge=0.0, le=0.4, doc="width of the picture's rim that is never judged, in its shorter sides"
    )
    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body; the floor below it is free")

    def check(self) -> None:
        """Check that the grid is neither too coarse nor too fine for its size and for what moves on it."""
        RollingGrid.check(self.size_m, self.cell_m)
        reach = self.max_mover_mps * _LOOK_BACK_S / self.cell_m
        if self.ahead_s and reach > _MAX_REACH:
            what = f"'max_mover_mps' {self.max_mover_mps:g} is {reach:.0f} cells in {_LOOK_BACK_S:g} s"
            raise ParamError("max_mover_mps", what, f"a search reaches {_MAX_REACH}: larger cells, or less speed")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Know nothing."""
        self._mount = MaskMount(self.camera_height_m, self.tilt_deg, self.fov_deg, self.camera_forward_m)
        self._continuity = Continuity()
        self._recoveries = 0
        self._near: Bools | None = None
        gains = np.array([[0.0, -self.miss, self.hit], [0.0, -1.0, 1.0]], np.float32)
        self._gains = gains[0], gains[1]
        self._start()

    def step(
        self,
        plane: Plane,
        motion: Motion,
        stamp: Stamp,
        deviation: FlowDeviation | None = None,
        recovery: Latest[RecoveryState] = _NO_RECOVERY,
    ) -> LocalMap:
        """Return the map with this frame.

        It restarts after a gap of more than 3 periods, and where the motion is longer than half of the map: odometry
        that jumps does not tell where the robot is on it.
        """
        usable = without_jump(motion, self.size_m)
        if self._continuity.breaks(stamp) or usable is not motion:
            self._start()
        motion, grid = usable, self._grid
        grid.move(motion)
        self._forget(recovery.value)
        labels = self._labels(plane)
        box = grid.box_of(self._in_view_m)
        shown_by = grid.shown_by(labels.shape, self._mount.floor_to_pixels(*labels.shape), box)
        moved_m = math.hypot(motion.forward_m, motion.left_m)
        self._driven_m += moved_m
        weight: Floats | np.float32 = np.float32(min(1.0, moved_m / self.full_motion_m))
        if deviation is not None:
            weight = weight * np.square(deviation.sureness_at(labels.shape, plane.step_px, self.sure_px))
        seen = _taken(labels, shown_by)
        self._add(box, seen, *(_taken(gains[labels] * weight, shown_by) for gains in self._gains))
        place = grid.box.moved(grid.corner[1], grid.corner[0])
        look = Look(stamp, seen, box.moved(place.top, place.left), place)
        movers = self._movers.find(look, self.min_mover_mps) if self.ahead_s else []
        self._forget_where_they_were(movers, look, box)
        grid.stand(self.robot_radius_m, -self.max_free_evidence)
        return self._map(swept(place, movers, self.ahead_s) if movers else None)

    def _forget_where_they_were(self, movers: list[Mover], look: Look, box: Box) -> None:
        """Believe at once that the floor behind what moves is free."""
        if movers:
            behind = cv2.dilate(swept(look.box.grown(1), movers, -1.0), _BESIDE)[1:-1, 1:-1]
            self._grid.evidence[box.cells][(behind != 0) & (look.labels == GROUND)] = _PRESUMED_FREE

    def _forget(self, recovery: RecoveryState | None) -> None:
        """Forget obstacles that few frames have shown, when a recovery begins."""
        if recovery is not None and recovery.recoveries != self._recoveries:
            self._recoveries = recovery.recoveries
            grid = self._grid
            few = (grid.evidence > _FORGOTTEN) & (grid.shown < recovery.doubt)
            grid.evidence[few] = _FORGOTTEN
            grid.forgotten |= few

    def _start(self) -> None:
        self._driven_m = 0.0
        self._movers = Movers(_LOOK_BACK_S, self.max_mover_mps, self.cell_m)
        self._grid = RollingGrid(self.size_m, self.cell_m)

    def _labels(self, plane: Plane) -> Bytes:
        """Return the labels of the plane's cells, 0 beyond the distance that is used."""
        shape = plane.valid.shape
        if self._near is None or self._near.shape != shape:
            self._near = self._mount.floor_distance_m(*shape) <= self.max_distance_m
            self._in_view_m = self._mount.hull_m(self._near)
        obstacle = plane.obstacle
        if self.unjudged == "obstacle":
            obstacle = obstacle | plane.unknown(self.rim_ratio)
        labels = np.where(plane.valid != 0, np.uint8(GROUND), np.uint8(0))
        labels[cv2.dilate(obstacle, _BESIDE) != 0] = 0
        labels[self._feet(obstacle) != 0] = OBSTACLE
        labels[~self._near] = 0
        return labels

    def _feet(self, obstacle: Bytes) -> Bytes:
        """Return where obstacles (rows, cols) stand: their lowest part, and below it down by ``blind_height_m``."""
        grown = obstacle
        for height_m in (self.blind_height_m / 2, self.blind_height_m):
            grown = np.maximum(grown, self._mount.outward(obstacle, height_m))
        return grown & ~self._mount.inward(obstacle, 0.0, self.foot_m)

    def _add(self, box: Box, seen: Bytes, evidence: Floats, shown: Floats) -> None:
        """Add what the cells of a box gain in this frame."""
        evidence += self._grid.evidence[box.cells]
        np.clip(evidence, -self.max_free_evidence, self.max_evidence, evidence)
        if self._driven_m < self.presumed_m:
            evidence[(seen == GROUND) & (np.abs(evidence) < -_PRESUMED_FREE)] = _PRESUMED_FREE
        self._grid.evidence[box.cells] = evidence
        shown += self._grid.shown[box.cells]
        np.maximum(shown, 0.0, out=self._grid.shown[box.cells])

    def _map(self, ahead: Bytes | None) -> LocalMap:
        grid = self._grid
        state = (grid.evidence <= _PRESUMED_FREE).view(np.uint8)
        state += LocalMap.OBSTACLE * (grid.evidence >= _OBSTACLE_EVIDENCE).view(np.uint8)
        left, top, cols, rows = cv2.boundingRect(state)
        known = Box(top, left, top + rows, left + cols).grown(1).within(grid.box)
        small = small_regions(
            state[known.cells] == LocalMap.UNKNOWN, self.min_unknown_m2 / grid.cell_m**2, known, grid.box
        )
        if small is not None:
            state[known.cells][small & ~grid.forgotten[known.cells]] = LocalMap.FREE
        if ahead is not None:
            state[ahead != 0] = LocalMap.MOVING
        return grid.to_map(state)


def small_regions(cells: Bools, min_cells: float, box: Box, grid: Box) -> Bools | None:
    """Return those ``cells`` (rows, cols) of a box that are in connected regions of fewer than so many, None for none.

    A region at a side of the box beyond which the grid goes on is not small: it goes on, too.
    """
    _, labels, stats, _ = cv2.connectedComponentsWithStats(cells.view(np.uint8), connectivity=4)
    is_small = stats[:, cv2.CC_STAT_AREA] < min_cells
    is_small[0] = False
    sides = (labels[0], labels[:, 0], labels[-1], labels[:, -1])
    for side, at, end in zip(sides, box, grid, strict=True):
        if at != end:
            is_small[side] = False
    return np.asarray(is_small[labels]) if is_small.any() else None


def _taken(values: Picture, shown_by: Indices) -> Picture:
    """Return the values (rows, cols) of a picture's cells at the cells of the grid that they show, else 0."""
    padded = np.zeros(values.size + 1, values.dtype)
    padded[1:] = values.reshape(-1)
    return padded.take(shown_by)


class MaskMount(Mount):
    """A mounting that moves masks of pixels towards the camera's foot and away from it."""

    def hull_m(self, mask: Bools) -> Doubles:
        """Return points (n, 2) of the floor in the robot's frame whose convex hull holds what the pixels of a mask see.

        ``mask``: (rows, cols). A pixel whose rim reaches the horizon sees as far as 100 times the camera's height.
        """
        rows, cols = np.nonzero(mask)
        x, y = (np.add.outer(at, _RIMS).ravel() for at in (cols, rows))
        x, y = (at.reshape(len(rows), 2) for at in (x, y))
        corners = np.stack([*np.broadcast_arrays(x[:, :, None], y[:, None, :], 1.0)], axis=-1).reshape(-1, 3)
        rays = corners @ np.linalg.inv(self.intrinsics(*mask.shape)).T @ self.R_CR
        down = np.maximum(-rays[:, 2], np.hypot(rays[:, 0], rays[:, 1]) / _FARTHEST)
        points_m = self.height_m * rays[:, :2] / np.maximum(down, 1e-9)[:, None] + (self.forward_m, 0.0)
        hull: Doubles = cv2.convexHull(points_m.astype(np.float32)).reshape(-1, 2).astype(np.float64)
        return hull

    def outward(self, mask: Bytes, height_m: float) -> Bytes:
        """Return a mask (rows, cols) of things on the floor with what is below them, down by a height.

        Vertical lines meet in the pixel of the camera's foot: every pixel is taken from farther out.
        """
        return self.inward(mask, -height_m)

    def inward(self, mask: Bytes, height_m: float, floor_m: float = 0.0) -> Bytes:
        """Return a mask (rows, cols) with every pixel taken from nearer to the camera's foot.

        Nearer by what ``height_m`` shifts it, and by ``floor_m`` on the floor below the camera.
        """
        key = (*mask.shape, height_m, floor_m)
        if key not in self._maps:
            self._maps[key] = self._inward_map(*key)
        found: Bytes = cv2.remap(mask, self._maps[key], None, cv2.INTER_NEAREST)
        return found

    @cached_property
    def _maps(self) -> dict[tuple[int, int, float, float], Floats]:
        return {}

    def _inward_map(self, rows: int, cols: int, height_m: float, floor_m: float) -> Floats:
        matrix = self.intrinsics(rows, cols)
        x, y, depth = matrix @ self.R_CR @ [0.0, 0.0, -1.0]
        foot = np.array([x, y]) / depth
        away = np.dstack(np.meshgrid(np.arange(cols), np.arange(rows))) - foot
        length = np.maximum(np.linalg.norm(away, axis=-1, keepdims=True), 1e-6)
        kept = (1.0 - height_m / self.height_m) - floor_m * matrix[0, 0] / self.height_m / length
        return np.asarray(foot + away * np.maximum(kept, 0.0), np.float32)
