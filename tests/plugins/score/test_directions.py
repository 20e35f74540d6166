"""Scores say of which of their figures less is better."""

import pytest
from graphnav_score import graphnav_stages

from graphnav import Stage

LESS = {"collision", "timeout", "path_length_m", "duration_s", "mean_jerk_mps3", "false_obstacle_ratio"}
LESS |= {"flicker_ratio", "epe_px", "outlier_ratio", "angle_error_rad"}


def test_less_is_better_where_it_is() -> None:
    assert frozenset().union(*(score.less_is_better for score in graphnav_stages())) == LESS


@pytest.mark.parametrize("score", graphnav_stages())
def test_directions_are_of_figures_that_the_score_tells_of(score: type[Stage]) -> None:
    assert all(f"``{figure}``" in (score.__doc__ or "") for figure in score.less_is_better)
