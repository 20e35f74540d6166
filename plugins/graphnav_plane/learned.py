"""Dominant plane by a small neural network on flow and planar flow, taught with the truth of a simulator."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from graphnav import Continuity, Flow, Planar, Plane, Stage, Stamp, param
from graphnav_plane.detector import MIN_VECTORS, all_ground
from graphnav_plane.learning.features import Features
from graphnav_plane.learning.model_file import TEACH, read_model


class Learned(Stage):
    """Dominant plane by a multilayer perceptron, taught on simulated drives with their true obstacles.

    The rival that learns from examples what the other detectors derive from geometry. It sees of each cell the flow,
    the planar flow times one robust gain, what that leaves of the flow now and over the last frames, alone and around
    the cell, and the cell's place in the picture; it sees no image. The score is the log-odds of obstacle.

    What it was taught with, it knows: camera, speed, frame rate, flow and maps. `tools/teach_learned.py` teaches it for
    others; maps, seeds and versions are in the model's file.
    """

    model: Path = param(Path("models/learned_160x120.npz"), doc="learned model, as saved by tools/teach_learned.py")
    threshold_ratio: float = param(
        0.5, gt=0.0, lt=1.0, doc="a cell is obstacle if its probability of being one is larger than this"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Read the model; forget the last frames."""
        self._model = read_model(self.model)
        self._features = Features()
        self._continuity = Continuity()

    def check(self) -> None:
        """Check that the model can be read."""
        read_model(self.model)

    def step(self, flow: Flow, planar: Planar, stamp: Stamp) -> Plane:
        """Return the plane on the grid of ``planar``; nothing is judged where fewer than 6 vectors are valid.

        Raises
        ------
        ValueError
            Flow and planar flow are of different image sizes or cover different times, or the model was taught on
            another grid.
        """
        if self._continuity.breaks(stamp):
            self._features.forget()
        features, valid, step_px = self._features.of(flow, planar, MIN_VECTORS)
        if (valid.shape, step_px) != (self._model.shape, self._model.step_px):
            (rows, cols), (taught_rows, taught_cols) = valid.shape, self._model.shape
            raise ValueError(
                f"the learned model is {taught_cols}x{taught_rows} cells of {self._model.step_px} px, "
                f"but the planar flow is {cols}x{rows} cells of {step_px} px; {TEACH}"
            )
        if not len(features):
            return all_ground(valid.shape, step_px)
        score = np.zeros(valid.shape, np.float32)
        score[valid] = self._model.network.log_odds(features)
        threshold = math.log(self.threshold_ratio / (1 - self.threshold_ratio))
        obstacle = (score > threshold) & valid
        return Plane(
            obstacle=obstacle.astype(np.uint8),
            score=score,
            valid=valid.astype(np.uint8),
            step_px=step_px,
            obstacle_ratio=np.count_nonzero(obstacle) / np.count_nonzero(valid),
            threshold=threshold,
        )
