"""Scores declare which values of their metrics are better, and what a failed drive counts as."""

import ast
from pathlib import Path

from graphnav_score import graphnav_stages

import graphnav
from graphnav import UNDEFINED
from graphnav.core.runner import Outcome
from graphnav.core.stage import metrics_of

METRICS = [metric for score in graphnav_stages() for metric in metrics_of(score).values()]

LOWER = {"collision", "timeout", "path_length_m", "duration_s", "mean_jerk_mps3", "false_obstacle_ratio"}
LOWER |= {"hit_mover", "hit_by_mover", "at_fault", "drove_into", "own_share", "arrival_s"}
LOWER |= {"flicker_ratio", "epe_px", "outlier_ratio", "angle_error_rad", "never_sighted_ratio", "mean_sighting_delay_m"}
LOWER |= {"mean_time_to_react_s", "unjudged_obstacle_ratio"}
NEITHER = {"frames", "counted_frames_ratio", "median_variance_ratio", "alpha_taken_ratio", "obstacles", "reacted_ratio"}
NEITHER |= {"row_auroc", "unmet_labels"}


def test_lower_is_better_where_it_is() -> None:
    assert {metric.name for metric in METRICS if metric.better == "lower"} == LOWER
    assert {metric.name for metric in METRICS if metric.better == "neither"} == NEITHER


def test_a_failed_drive_has_no_success_and_no_length() -> None:
    assert {metric.name for metric in METRICS if metric.if_failed == 0.0} == {
        "success",
        "spl",
        "oracle_spl",
        "sct",
        "barn_metric",
    }
    undefined = {metric.name for metric in METRICS if metric.if_failed == UNDEFINED}
    assert undefined == {"path_length_m", "duration_s", "mean_jerk_mps3", "arrival_s"}
    assert {metric.name for metric in METRICS if metric.is_outcome} == {"success"}


def test_the_core_knows_no_metric_by_name() -> None:
    """But those of version 0.1.0, which did not declare them; a count of frames and the outcomes are every run's."""
    names = {metric.name for metric in METRICS} - {"frames", *Outcome}
    folders = (
        Path(graphnav.__file__).parent / name
        for name in ("studies/ablation", "core/report", "core/runner", "core/stage")
    )
    known = {
        (path.name, node.value)
        for folder in folders
        for path in folder.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and node.value in names
    }
    assert {path for path, _ in known} == {"former_names.py"}
