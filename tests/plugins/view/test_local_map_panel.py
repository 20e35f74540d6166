"""The panel of a local map is centred on the robot, and stands where the log has one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from graphnav_view.panels.frame_panels import draw_surroundings, frame_panels
from graphnav_view.panels.keyframe import Frame
from matplotlib import pyplot as plt

from graphnav import LocalMap

STATE = np.full((90, 90), LocalMap.FREE, np.uint8)
LOCAL = LocalMap(0.1, -4.0, -3.0, 1.0, 0.5, 0.3, STATE)


def test_the_robot_is_in_the_middle() -> None:
    figure, axes = plt.subplots(figsize=(4, 3))
    caption = draw_surroundings(axes, LOCAL)
    left_m, right_m = axes.get_xlim()
    low_m, high_m = axes.get_ylim()
    assert ((left_m + right_m) / 2, (low_m + high_m) / 2) == pytest.approx((1.0, 0.5))
    assert high_m - low_m == pytest.approx(4.0)
    # The middle of cell (0, 0) is at the map's origin: the picture begins half a cell before it.
    assert axes.images[0].get_extent() == pytest.approx((-4.05, 4.95, -3.05, 5.95))
    assert "unknown" in caption
    plt.close(figure)


def test_a_frame_with_a_local_map_has_the_panel() -> None:
    bare = Frame(0, None, None, None, None, None, None)
    assert not list(frame_panels(None, None, bare))
    assert [panel.title for panel in frame_panels(None, None, replace(bare, local_map=LOCAL))] == ["local map"]
