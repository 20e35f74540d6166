"""How well a detector tells obstacle from ground."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import cv2
import numpy as np

import graphnav
from graphnav import Metric, Role, Stage, Truth, param
from graphnav_score.detection import (
    AUROC,
    BALANCED_ACCURACY,
    FALSE_ALARM_RATIO,
    RECALL,
    balanced_accuracy,
    judged_ratio,
    share,
)
from graphnav_score.frame_metrics import of_frames
from graphnav_score.frames import Frames
from graphnav_score.pixels import count_pixels
from graphnav_score.roc import Roc


class Plane(Stage):
    """How well a detector tells obstacle from ground.

    Compares at the truth's pixels: every cell speaks for all of its pixels, only cells that the detector judged count,
    and the pixels of all frames are pooled. A frame counts if between ``min_obstacle_ratio`` and ``max_obstacle_ratio``
    of its true picture is obstacle: beyond one half the ground is not the dominant plane; and if something in it moved
    by ``min_motion_px``: where the camera stands still there is no flow, and no detector can tell. That is motion in
    the true picture, not of the robot: while the robot stands, frames of a camera that shakes count, and so do those in
    which a person walks past.

    What that leaves out is told by ``counted_frames_ratio`` and ``unjudged_obstacle_ratio``, and counts in
    ``auroc_all`` and ``balanced_accuracy_all_ratio``: all frames with motion, whatever share of them is obstacle, and
    all of their pixels. There, what was not judged (mostly the rim of the picture) is called ground and scores lowest.

    A metric that is not defined (no such frame, no obstacle, no ground) is left out.
    """

    role: ClassVar[Role] = "score"
    metrics: ClassVar[tuple[Metric, ...]] = of_frames(
        Metric("frames", better="neither", bounds=(0.0, None), help="Frames that count."),
        Metric(
            "counted_frames_ratio",
            unit="ratio",
            better="neither",
            bounds=(0.0, 1.0),
            help="Frames that count, as a share of all in which something moved.",
        ),
        judged_ratio("their pixels"),
        AUROC,
        RECALL,
        BALANCED_ACCURACY,
        Metric(
            "iou_ratio",
            unit="ratio",
            better="higher",
            bounds=(0.0, 1.0),
            min_difference=0.02,
            help="Of the map: intersection over union of obstacle, pooled.",
        ),
        Metric(
            "false_obstacle_ratio",
            unit="ratio",
            better="lower",
            bounds=(0.0, 1.0),
            min_difference=0.01,
            help="Share of ground called obstacle, over the frames that count and those without any obstacle.",
        ),
        Metric(
            "auroc_all",
            better="higher",
            bounds=(0.0, 1.0),
            min_difference=0.01,
            help="`auroc` of all frames with motion, with what was not judged as ground.",
        ),
        Metric(
            "balanced_accuracy_all_ratio",
            unit="ratio",
            better="higher",
            bounds=(0.0, 1.0),
            min_difference=0.01,
            help="`balanced_accuracy_ratio` of all frames with motion, with what was not judged as ground.",
        ),
        Metric(
            "unjudged_obstacle_ratio",
            unit="ratio",
            better="lower",
            bounds=(0.0, 1.0),
            min_difference=0.02,
            help="Share of the obstacle in all frames with motion that was not judged.",
        ),
        Metric(
            "flicker_ratio",
            unit="ratio",
            better="lower",
            bounds=(0.0, 1.0),
            min_difference=0.01,
            help="Share of cells whose map changed since the last frame although the truth did not; all frames.",
        ),
    )

    min_obstacle_ratio: float = param(0.05, ge=0.0, le=1.0, doc="minimum true share of obstacle in a frame that counts")
    max_obstacle_ratio: float = param(0.5, ge=0.0, le=1.0, doc="maximum true share of obstacle in a frame that counts")

    min_motion_px: float = param(
        0.1,
        ge=0.0,
        le=100_000.0,
        doc="true flow, right or down, that somewhere in the picture makes a frame count, also where the robot stands "
        "and the camera shakes or something moves past; 0 counts all",
        renamed_from="least_motion_px",
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget everything counted."""
        self._roc, self._other_roc = Roc(), Roc()
        self._frames = self._moving = 0
        # Pixels by what they are and what they are called: rows ground, obstacle; columns called ground, called
        # obstacle, not judged.
        self._confusion, self._empty, self._all = np.zeros((3, 2, 3), np.int64)
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
        moves = self._moves(truth)
        counts = moves and self.min_obstacle_ratio <= obstacle_ratio <= self.max_obstacle_ratio
        self._frames += counts
        self._moving += moves
        if self._pending is None or self._pending.is_full or self._pending.shape != shape:
            self._count_pending()
        if self._pending is None or self._pending.shape != shape:
            self._pending = Frames(shape)
        self._pending.add(plane, pixels, counts=counts, is_empty=not counts and obstacle_pixels == 0, moves=moves)

    def merge(self, other: Plane) -> None:
        """Add what ``other`` counted, so that the frames of several drives are pooled."""
        self._count_pending()
        other._count_pending()
        self._roc.merge(other._roc)
        self._other_roc.merge(other._other_roc)
        self._frames += other._frames
        self._moving += other._moving
        self._all += other._all
        self._confusion += other._confusion
        self._empty += other._empty
        self._changed += other._changed
        self._kept += other._kept

    def summary(self) -> Mapping[str, float]:
        """Return the metrics that are defined."""
        self._count_pending()
        (kept, false, _), (missed, hit, _) = self._confusion.tolist()
        (all_kept, all_false, rim_ground), (all_missed, all_hit, rim_obstacle) = self._all.tolist()
        empty_kept, empty_false, _ = self._empty[0].tolist()
        all_obstacle = all_hit + all_missed + rim_obstacle
        values = {
            "counted_frames_ratio": share(self._frames, self._moving),
            "judged_ratio": share(kept + false + missed + hit, int(self._confusion.sum())),
            "auroc": self._roc.area(),
            "recall_at_5_false_alarms_ratio": self._roc.recall(FALSE_ALARM_RATIO),
            "balanced_accuracy_ratio": balanced_accuracy(kept, false, missed, hit),
            "iou_ratio": share(hit, hit + missed + false),
            "false_obstacle_ratio": share(false + empty_false, kept + false + empty_kept + empty_false),
            "auroc_all": self._auroc_all(rim_obstacle, rim_ground),
            "balanced_accuracy_all_ratio": balanced_accuracy(
                all_kept + rim_ground, all_false, all_missed + rim_obstacle, all_hit
            ),
            "unjudged_obstacle_ratio": share(rim_obstacle, all_obstacle),
            "flicker_ratio": share(self._changed, self._changed + self._kept),
        }
        return {"frames": float(self._frames)} | {name: value for name, value in values.items() if value is not None}

    def _auroc_all(self, unjudged_obstacle: int, unjudged_ground: int) -> float | None:
        """Return the area over the frames that count and the others, with what was not judged."""
        pooled = Roc()
        for roc in (self._roc, self._other_roc):
            pooled.merge(roc)
        pooled.add_lowest(unjudged_obstacle, unjudged_ground)
        return pooled.area()

    def _moves(self, truth: Truth) -> bool:
        # The nearest ground, in the last row, moves most: hardly ever the other rows are needed.
        flow_px = truth.flow_px
        return (
            cv2.norm(flow_px[-1:], cv2.NORM_INF) >= self.min_motion_px
            or cv2.norm(flow_px, cv2.NORM_INF) >= self.min_motion_px
        )

    def _count_pending(self) -> None:
        if self._pending is None or not self._pending.n:
            return
        confusion, empty, moving = self._pending.confusions()
        self._confusion += confusion
        self._empty += empty
        self._all += moving
        self._roc.add(*self._pending.scores(counted=True))
        self._other_roc.add(*self._pending.scores(counted=False))
        changed, kept = self._pending.flicker()
        self._changed += changed
        self._kept += kept
        self._pending.clear()
