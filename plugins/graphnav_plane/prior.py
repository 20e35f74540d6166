"""Obstacle by a detector and by height in the picture, their log-odds added."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Literal

import numpy as np

from graphnav import Plane, Stage, param
from graphnav.arrays import Doubles

_TINY = 1e-12
"""Added to scores and thresholds, so that a score of 0 at a threshold of 0 is even odds."""
_MAX_LOG_ODDS = 15.0
"""Beyond it float32 has no probabilities below 1 left."""
_EVEN = 0.5


class Prior(Stage):
    """Dominant plane by a detector's scores and a prior of the picture's rows, as a forward camera has it.

    What is high in the picture of a forward camera is far, and more often obstacle than floor. The odds of a row are a
    logistic of its height, even at ``horizon_ratio``; those of a cell are its score divided by the detector's
    threshold, to the power of ``detector_weight``. Both are multiplied (log-odds are added), as if row and score were
    independent. The published score is the probability of obstacle, the threshold one half. The detector's own map is
    not used, so that its filters (``edge_ratio``, ``min_cells``) have no effect.

    Takes the plane of any detector. With ``detector_weight: 0`` the row alone decides, as in `plane.row_prior`. For a
    camera that looks down the rows tell nothing: there it only does harm.
    """

    horizon_ratio: float = param(
        0.25,
        ge=-10.0,
        le=10.0,
        doc="row of even odds, as a share of the picture's rows from the top; less than 0 is above the picture, as "
        "after cropping: fewer obstacles",
    )
    width_ratio: float = param(
        0.1,
        gt=0.0,
        le=10.0,
        doc="share of the rows over which the odds of the row change by the factor e: less is a sharper border",
    )
    detector_weight: float = param(
        0.4, ge=0.0, le=100.0, doc="dimensionless: weight of the detector's log-odds; 0: the row alone"
    )
    max_score_ratio: float = param(
        20.0,
        gt=1.0,
        le=1e6,
        doc="a score counts as at most this many times the threshold, and at least one part in as many of it, so that "
        "no score outweighs every row",
    )
    scores: Literal["ratio", "log_odds"] = param(
        "ratio",
        doc="ratio: odds are the score divided by the threshold, for lengths, deviations and shares, which are never "
        "negative; log_odds: the score minus the threshold are the log-odds, for plane.learned",
    )
    fills_unjudged: bool = param(
        False, doc="judge what the detector does not by the row alone; false: it stays not judged"
    )

    def step(self, plane: Plane) -> Plane:
        """Return the plane on the same cells.

        Raises
        ------
        ValueError
            A judged score is negative, and so neither a length nor a share.
        """
        judged = plane.valid != 0
        detector = np.where(judged, self._detector_log_odds(np.where(judged, plane.score, np.float32(0)), plane), 0.0)
        rows = row_log_odds(len(judged), self.horizon_ratio, self.width_ratio)
        log_odds = np.clip(rows + self.detector_weight * detector, -_MAX_LOG_ODDS, _MAX_LOG_ODDS)
        valid = judged | self.fills_unjudged
        score = np.where(valid, 1 / (1 + np.exp(-log_odds)), 0.0)
        obstacle = score > _EVEN
        return replace(
            plane,
            obstacle=obstacle.astype(np.uint8),
            score=score.astype(np.float32),
            valid=valid.astype(np.uint8),
            obstacle_ratio=int(np.count_nonzero(obstacle)) / max(int(np.count_nonzero(valid)), 1),
            threshold=_EVEN,
        )

    def _detector_log_odds(self, scores: Doubles, plane: Plane) -> Doubles:
        limit = np.log(self.max_score_ratio)
        if self.scores == "log_odds":
            return np.clip(scores - plane.threshold, -limit, limit)
        if scores.size and scores.min() < 0:
            raise ValueError(
                f"a score is {scores.min():.3g}, but scores are compared with the threshold as ratios: "
                "set 'scores: log_odds' if the detector publishes log-odds"
            )
        ratio = (scores.astype(np.float64) + _TINY) / (plane.threshold + _TINY)
        return np.clip(np.log(ratio), -limit, limit)


@lru_cache(maxsize=16)
def row_log_odds(rows: int, horizon_ratio: float, width_ratio: float) -> Doubles:
    """Return the log-odds of obstacle by the height of a row alone, (rows, 1)."""
    down_ratio = (np.arange(rows)[:, None] + 0.5) / rows
    log_odds: Doubles = (horizon_ratio - down_ratio) / width_ratio
    log_odds.setflags(write=False)
    return log_odds
