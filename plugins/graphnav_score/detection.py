"""The metrics of detectors of obstacle: their declarations, and their values from counts of pixels."""

from __future__ import annotations

from graphnav import Metric

FALSE_ALARM_RATIO = 0.05

AUROC = Metric(
    "auroc",
    better="higher",
    bounds=(0.0, 1.0),
    min_difference=0.01,
    is_key=True,
    help="Area under the receiver operating characteristic of the score.",
)
RECALL = Metric(
    "recall_at_5_false_alarms_ratio",
    unit="ratio",
    better="higher",
    bounds=(0.0, 1.0),
    min_difference=0.02,
    help="Share of obstacle found where the score is split so that 5 % of the ground is called obstacle.",
)
BALANCED_ACCURACY = Metric(
    "balanced_accuracy_ratio",
    unit="ratio",
    better="higher",
    bounds=(0.0, 1.0),
    min_difference=0.01,
    help="Of the map: mean of the recalls of obstacle and of ground.",
)


def judged_ratio(of: str) -> Metric:
    """Declare the share of some pixels that a detector judges; ``of``: which."""
    return Metric(
        "judged_ratio",
        unit="ratio",
        better="higher",
        bounds=(0.0, 1.0),
        min_difference=0.02,
        help=f"Share of {of} that was judged.",
    )


def share(part: float, total: float) -> float | None:
    """Return the share of a part, None of nothing."""
    return part / total if total else None


def balanced_accuracy(kept: float, false: float, missed: float, hit: float) -> float | None:
    """Return the mean of the recalls of ground and of obstacle, None without pixels of both.

    ``kept``, ``false``: pixels of ground that are called ground and called obstacle; ``missed``, ``hit``: pixels of
    obstacle that are called ground and called obstacle.
    """
    ground, obstacle = share(kept, kept + false), share(hit, hit + missed)
    return None if ground is None or obstacle is None else (ground + obstacle) / 2
