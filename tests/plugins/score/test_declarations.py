"""How the scores declare their metrics: what studies may compare, and what can stop them."""

from __future__ import annotations

import graphnav_score
import pytest

from graphnav import Metric

METRICS = {
    f"{stage.__name__}.{metric.name}": metric for stage in graphnav_score.graphnav_stages() for metric in stage.metrics
}
ZERO_OR_ONE = ("success", "timeout", "collision", "hit_mover", "hit_by_mover", "at_fault", "spl", "oracle_spl", "sct")


@pytest.mark.parametrize("metric", [m for m in METRICS.values() if "auroc" in m.name], ids=lambda metric: metric.name)
def test_an_area_depends_on_the_frames_and_is_a_share(metric: Metric) -> None:
    assert metric.of_frames
    assert metric.bounds == (0.0, 1.0)


def test_all_that_components_measure_depends_on_the_frames() -> None:
    assert all(metric.of_frames for name, metric in METRICS.items() if name.startswith("Components."))


@pytest.mark.parametrize("name", ZERO_OR_ONE)
def test_what_a_drive_came_to_can_stop_a_study(name: str) -> None:
    assert METRICS[f"Navigation.{name}"].span == (0.0, 1.0)
