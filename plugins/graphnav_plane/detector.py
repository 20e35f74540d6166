"""Base of the detectors of the dominant plane: from residuals of the ground to a map."""

from __future__ import annotations

from typing import Literal

import cv2
import numpy as np
import numpy.typing as npt

from graphnav import Continuity, Flow, Planar, Plane, Stage, Stamp, coarsen, param
from graphnav.arrays import Bools, Floats
from graphnav_plane.memory import Memory

Vectors = npt.NDArray[np.floating]
Rule = Literal["mad", "otsu", "fixed"]
"""How `threshold` finds the score above which a cell is obstacle."""
MIN_VECTORS = 6
MAX_INTERVAL_ERROR_RATIO = 0.01
_NEXT = np.ones((3, 3), np.uint8)
_NEIGHBOURS = 8
LENGTH_FLOOR_PX = 1.0
"""Added to the flow's length before scores are divided by it: what is left of a flow near zero is noise."""
_BINS = 128
"""Of the histogram that the rule otsu splits."""


class Detector(Stage):
    """A stage that scores how far each cell is from moving like the ground, and splits at a threshold.

    The score is in pixels, or with ``threshold_ratio`` relative to the flow's length.
    """

    rule: Rule = param(
        "mad",
        doc="mad: mad_ratio times the median score; otsu: split the histogram; fixed: threshold_px or threshold_ratio",
    )
    mad_ratio: float = param(4.0, gt=0.0, le=1e6, doc="rule mad: more marks fewer cells as obstacle")
    threshold_px: float = param(
        0.08,
        ge=0.0,
        le=100_000.0,
        doc="rule fixed: the threshold. Other rules: its minimum, which should be the flow noise on a free floor, "
        "where every relative rule finds obstacles in the noise",
    )
    threshold_ratio: float | None = param(
        None,
        ge=0.0,
        le=1e6,
        doc="null: scores are in px. Else they are divided by the flow's length at the cell plus one pixel, so that "
        "they are ratios, and in every rule this takes the place of threshold_px, which fits keep (0.2: obstacle is "
        "where the ground's motion leaves more than a fifth of a long vector). For forward cameras, where flow and its "
        "errors grow from the horizon to the wheels",
    )
    median_cells: int = param(
        1,
        ge=1,
        le=15,
        doc="side of the median filter that removes specks from the map (odd); 1 does not filter, as in [OI]",
    )
    edge_ratio: float = param(
        0.3,
        ge=0.0,
        lt=1.0,
        doc="a cell is ground if it scores less than this share of a neighbouring cell: flow is estimated in windows, "
        "so that ground beside an obstacle moves a little like it; 0 keeps it obstacle",
    )
    strong_ratio: float = param(
        1.0,
        ge=1.0,
        le=1e6,
        doc="hysteresis (dimensionless): a connected region counts only if one of its cells scores more than this many "
        "times the threshold; with more than 1 the threshold can be lower; 1 keeps every cell above the threshold",
    )
    min_cells: int = param(
        1, ge=1, le=1_000_000, doc="minimum number of cells of a connected region that counts; 1 keeps all"
    )
    memory_ratio: float = param(
        0.5,
        ge=0.0,
        lt=1.0,
        doc="weight of the last frames, moved along with the flow, in the residual of a cell; more is steadier and "
        "later, 0 judges every frame separately",
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget the last frames."""
        self._memory = Memory(self.memory_ratio)
        self._continuity = Continuity()

    def _begin(self, stamp: Stamp) -> None:
        """Begin a step; after a gap of more than 3 periods the last frames are forgotten."""
        if self._continuity.breaks(stamp):
            self._memory.forget()

    def _unjudged(self, cells: Flow) -> Plane:
        """Return a plane without judged cells, and forget the last frames."""
        self._memory.forget()
        return all_ground(cells.valid.shape, cells.step_px)

    def _remembered(self, left_px: Vectors, valid: Bools, cells: Flow) -> Floats:
        """Return the scores (rows, cols), 0 where not ``valid``: the lengths of this frame's and the last residuals.

        With ``threshold_ratio`` they are relative to the flow's length. ``left_px``: (rows, cols, 2), finite where
        ``valid``, as the vectors of ``cells`` are.
        """
        moved_cells = cells.uv_px / np.float32(cells.step_px)
        mean = self._memory.mean(left_px.astype(np.float32, copy=False), valid, moved_cells)
        score: Floats = np.abs(mean.view(np.complex64)[..., 0])
        return score if self.threshold_ratio is None else relative(score, valid, cells)

    def _plane(self, score: Floats, valid: Bools, step_px: int, *, converged: bool = True) -> Plane:
        """Return the plane of these scores (rows, cols), which must be 0 where not ``valid``."""
        minimum = self.threshold_px if self.threshold_ratio is None else self.threshold_ratio
        limit = threshold(self.rule, score[valid], self.mad_ratio, minimum)
        is_obstacle = score > limit
        if self.edge_ratio:
            is_obstacle &= score > np.float32(self.edge_ratio) * cv2.dilate(score, _NEXT)
        if self.strong_ratio > 1.0 or self.min_cells > 1:
            is_obstacle = kept_regions(is_obstacle, score, self.strong_ratio * limit, self.min_cells)
        obstacle = is_obstacle.view(np.uint8)
        if self.median_cells > 1:
            obstacle = cv2.medianBlur(obstacle, self.median_cells | 1) & valid
        return Plane(
            obstacle=obstacle,
            score=score,
            valid=valid.astype(np.uint8),
            step_px=step_px,
            obstacle_ratio=int(np.count_nonzero(obstacle)) / max(int(np.count_nonzero(valid)), 1),
            threshold=limit,
            converged=converged,
        )


def all_ground(shape: tuple[int, ...], step_px: int) -> Plane:
    """Return a plane without obstacles in which nothing was judged."""
    empty = np.zeros(shape, np.uint8)
    return Plane(obstacle=empty, score=empty.astype(np.float32), valid=empty, step_px=step_px, obstacle_ratio=0.0)


def relative(score_px: Floats, valid: Bools, cells: Flow) -> Floats:
    """Return scores (rows, cols) divided by the lengths of the flow's vectors plus a pixel, 0 where not ``valid``."""
    vectors_px = np.ascontiguousarray(cells.uv_px, np.float32).view(np.complex64)[..., 0]
    ratio = np.zeros_like(score_px)
    np.divide(score_px, np.abs(vectors_px) + np.float32(LENGTH_FLOOR_PX), out=ratio, where=valid)
    return ratio


def compared(flow: Flow, planar: Planar) -> tuple[Flow, Bools]:
    """Return ``flow`` on the grid of ``planar`` and the cells in which both are valid.

    Raises
    ------
    ValueError
        Their image sizes differ, or their intervals differ by more than 1 %.
    """
    if abs(flow.interval_us - planar.interval_us) > MAX_INTERVAL_ERROR_RATIO * flow.interval_us:
        raise ValueError(
            f"the planar flow covers {planar.interval_us} us, but the flow {flow.interval_us} us: "
            "wire the flow from which the planar flow is derived"
        )
    cells = coarsen(flow, planar.step_px)
    if cells.valid.shape != planar.planar_valid.shape:
        (rows, cols), (planar_rows, planar_cols) = cells.valid.shape, planar.planar_valid.shape
        raise ValueError(
            f"the planar flow is {planar_cols}x{planar_rows} cells of {planar.step_px} px, "
            f"but the flow is {cols}x{rows} of them"
        )
    return cells, (cells.valid != 0) & (planar.planar_valid != 0)


def kept_regions(is_obstacle: Bools, score: Floats, strong_score: float, min_cells: int) -> Bools:
    """Return the cells of the regions that count, (rows, cols).

    A region is connected over sides and corners. It counts if it has at least ``min_cells`` cells and one of them
    scores more than ``strong_score`` (the second threshold of hysteresis [Canny: A computational approach to edge
    detection, 1986]).
    """
    count, labels, statistics, _ = cv2.connectedComponentsWithStats(
        is_obstacle.view(np.uint8), connectivity=_NEIGHBOURS
    )
    is_strong = np.zeros(count, np.bool_)
    is_strong[labels[is_obstacle & (score > strong_score)]] = True
    counts = is_strong & (statistics[:, cv2.CC_STAT_AREA] >= min_cells)
    counts[0] = False
    return np.asarray(counts[labels])


def threshold(rule: Rule, scores: npt.NDArray[np.floating], mad_ratio: float, minimum: float) -> float:
    """Return the score above which a cell is obstacle, at least ``minimum``.

    ``scores``: (n,), deviations from the ground, none negative, so that their median is the median absolute
    deviation (MAD). "mad": ``mad_ratio`` times it. "otsu": the split that maximizes the variance between both sides
    [Otsu: A threshold selection method from gray-level histograms, 1979]. "fixed": ``minimum``.
    """
    if rule == "fixed" or not scores.size:
        return minimum
    return max(minimum, mad_ratio * _median(scores) if rule == "mad" else _otsu(scores))


def _median(scores: npt.NDArray[np.floating]) -> float:
    """Return numpy's median of scores without NaN, several times as fast."""
    half = scores.size // 2
    if scores.size % 2:
        return float(np.partition(scores, half)[half])
    low, high = np.partition(scores, (half - 1, half))[half - 1 : half + 1]
    return float((low + high) / 2)


def _otsu(scores: npt.NDArray[np.floating]) -> float:
    count, edges = np.histogram(scores, _BINS)
    middle = (edges[:-1] + edges[1:]) / 2
    below = np.cumsum(count)[:-1]
    total = np.cumsum(count * middle)
    above = scores.size - below
    mean_gap = total[:-1] / np.maximum(below, 1) - (total[-1] - total[:-1]) / np.maximum(above, 1)
    return float(edges[1 + np.argmax(below * above * mean_gap**2)])
