"""Scores declare which values of their metrics are better, and what a failed drive counts as."""

from graphnav_score import graphnav_stages

from graphnav import UNDEFINED
from graphnav.stage import metrics_of

METRICS = [metric for score in graphnav_stages() for metric in metrics_of(score).values()]

LOWER = {"collision", "timeout", "path_length_m", "duration_s", "mean_jerk_mps3", "false_obstacle_ratio"}
LOWER |= {"flicker_ratio", "epe_px", "outlier_ratio", "angle_error_rad"}


def test_lower_is_better_where_it_is() -> None:
    assert {metric.name for metric in METRICS if metric.better == "lower"} == LOWER
    assert {metric.name for metric in METRICS if metric.better == "neither"} == {"frames"}


def test_a_failed_drive_has_no_success_and_no_length() -> None:
    assert {metric.name for metric in METRICS if metric.if_failed == 0.0} == {"success", "spl", "barn"}
    undefined = {metric.name for metric in METRICS if metric.if_failed == UNDEFINED}
    assert undefined == {"path_length_m", "duration_s", "mean_jerk_mps3"}
    assert [metric.name for metric in METRICS if metric.is_outcome] == ["success"]
