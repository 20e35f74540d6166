"""How well a detector tells obstacle from ground."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import cv2
import numpy as np

import graphnav
from graphnav import Metric, Stage, Truth, param
from graphnav_score.frames import Frames
from graphnav_score.pixels import count_pixels
from graphnav_score.roc import Roc

FALSE_ALARM_RATIO = 0.05


class Plane(Stage):
    """How well a detector tells obstacle from ground.

    Compares at the truth's pixels: every cell speaks for all of its pixels, only cells that the detector judged count,
    and the pixels of all frames are pooled. A frame counts if between ``min_obstacle_ratio`` and ``max_obstacle_ratio``
    of its true picture is obstacle: beyond one half the ground is not the dominant plane; and if something in it moved
    by ``min_motion_px``: where the camera stands still there is no flow, and no detector can tell.

    A metric that is not defined (no such frame, no obstacle, no ground) is left out.
    """

    metrics: ClassVar[tuple[Metric, ...]] = (
        Metric("frames", better="neither", help="Frames that count."),
        Metric(
            "judged_ratio",
            unit="ratio",
            better="higher",
            min_difference=0.02,
            help="Share of their pixels that was judged.",
        ),
        Metric(
            "auroc",
            better="higher",
            min_difference=0.01,
            help="Area under the receiver operating characteristic of the score.",
        ),
        Metric(
            "recall_at_5_false_alarms_ratio",
            unit="ratio",
            better="higher",
            min_difference=0.02,
            help="Share of obstacle found where the score is split so that 5 % of the ground is called obstacle.",
        ),
        Metric(
            "balanced_accuracy_ratio",
            unit="ratio",
            better="higher",
            min_difference=0.01,
            help="Of the map: mean of the recalls of obstacle and of ground.",
        ),
        Metric(
            "iou_ratio",
            unit="ratio",
            better="higher",
            min_difference=0.02,
            help="Of the map: intersection over union of obstacle, pooled.",
        ),
        Metric(
            "false_obstacle_ratio",
            unit="ratio",
            better="lower",
            min_difference=0.01,
            help="Share of ground called obstacle, over the frames that count and those without any obstacle.",
        ),
        Metric(
            "flicker_ratio",
            unit="ratio",
            better="lower",
            min_difference=0.01,
            help="Share of cells whose map changed since the last frame although the truth did not; all frames.",
        ),
    )

    min_obstacle_ratio: float = param(0.05, ge=0.0, le=1.0, doc="minimum true share of obstacle in a frame that counts")
    max_obstacle_ratio: float = param(0.5, ge=0.0, le=1.0, doc="maximum true share of obstacle in a frame that counts")

    min_motion_px: float = param(
        0.1,
        ge=0.0,
        doc="true flow, right or down, that somewhere in the picture makes a frame count; 0 counts all",
        renamed_from="least_motion_px",
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget everything counted."""
        self._roc = Roc()
        self._frames = 0
        self._pixels = 0
        # Pixels by what they are and what they are called: rows ground, obstacle; columns called ground, obstacle.
        self._confusion = np.zeros((2, 2), np.int64)
        self._empty = np.zeros(2, np.int64)
        self._pending: Frames | None = None
        self._changed = self._kept = 0

    def step(self, plane: graphnav.Plane, truth: Truth) -> None:
        """Count this frame.

        Raises
        ------
        ValueError
            The plane's grid does not fit the truth.
        """
        shape = plane.obstacle.shape
        pixels = count_pixels(truth, shape, plane.step_px)
        ground_pixels, obstacle_pixels = (int(cv2.sumElems(kind)[0]) for kind in pixels)
        obstacle_ratio = obstacle_pixels / max(ground_pixels + obstacle_pixels, 1)
        counts = self._counts(truth, obstacle_ratio)
        if counts:
            self._frames += 1
            self._pixels += ground_pixels + obstacle_pixels
        if self._pending is None or self._pending.is_full or self._pending.shape != shape:
            self._count_pending()
        if self._pending is None or self._pending.shape != shape:
            self._pending = Frames(shape)
        self._pending.add(plane, pixels, counts=counts, is_empty=not counts and obstacle_pixels == 0)

    def merge(self, other: Plane) -> None:
        """Add what ``other`` counted, so that the frames of several drives are pooled."""
        self._count_pending()
        other._count_pending()
        self._roc.merge(other._roc)
        self._frames += other._frames
        self._pixels += other._pixels
        self._confusion += other._confusion
        self._empty += other._empty
        self._changed += other._changed
        self._kept += other._kept

    def summary(self) -> Mapping[str, float]:
        """Return the metrics that are defined."""
        self._count_pending()
        (kept, false), (missed, hit) = self._confusion.tolist()
        ground_recall, recall = _share(kept, kept + false), _share(hit, hit + missed)
        values = {
            "judged_ratio": _share(int(self._confusion.sum()), self._pixels),
            "auroc": self._roc.area(),
            "recall_at_5_false_alarms_ratio": self._roc.recall(FALSE_ALARM_RATIO),
            "balanced_accuracy_ratio": _mean(ground_recall, recall),
            "iou_ratio": _share(hit, hit + missed + false),
            "false_obstacle_ratio": _share(false + int(self._empty[1]), kept + false + int(self._empty.sum())),
            "flicker_ratio": _share(self._changed, self._changed + self._kept),
        }
        return {"frames": float(self._frames)} | {name: value for name, value in values.items() if value is not None}

    def _counts(self, truth: Truth, obstacle_ratio: float) -> bool:
        if not self.min_obstacle_ratio <= obstacle_ratio <= self.max_obstacle_ratio:
            return False
        # The nearest ground, in the last row, moves most: hardly ever the other rows are needed.
        flow_px = truth.flow_px
        return (
            cv2.norm(flow_px[-1:], cv2.NORM_INF) >= self.min_motion_px
            or cv2.norm(flow_px, cv2.NORM_INF) >= self.min_motion_px
        )

    def _count_pending(self) -> None:
        if self._pending is None or not self._pending.n:
            return
        confusion, empty = self._pending.confusions()
        self._confusion += confusion
        self._empty += empty[0]
        self._roc.add(*self._pending.scores())
        changed, kept = self._pending.flicker()
        self._changed += changed
        self._kept += kept
        self._pending.clear()


def _share(part: int, total: int) -> float | None:
    return part / total if total else None


def _mean(one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else (one + other) / 2
