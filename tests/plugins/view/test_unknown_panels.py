"""Panels tell unknown cells from those of the rim."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from graphnav_view import style
from graphnav_view.panels.camera_panels import draw_plane
from graphnav_view.panels.keyframe import Frame

from graphnav import Plane
from graphnav.arrays import Bytes

ROWS, COLS = 30, 40


def drawn(valid: Bytes) -> tuple[str, list[str]]:
    """Return the caption and the hatches of a plane of ground with these judged cells."""
    nothing = np.zeros((ROWS, COLS), np.uint8)
    plane = Plane(nothing, nothing.astype(np.float32), valid, step_px=4, obstacle_ratio=0.0)
    axes = style.new_figure(4, 4).add_subplot()
    caption = draw_plane(axes, replace(Frame(0, None, None, None, None, None, None), plane=plane))
    return caption, [str(patch.get_hatch()) for patch in axes.patches]


def test_only_what_there_is_is_hatched_and_named() -> None:
    valid = np.ones((ROWS, COLS), np.uint8)
    caption, hatches = drawn(valid)
    assert not hatches
    assert "rim" not in caption
    assert "unknown" not in caption
    valid[:2] = 0
    caption, hatches = drawn(valid)
    assert hatches == ["/////"]
    assert "gray: rim;" in caption
    valid[14:20, 20:30] = 0
    caption, hatches = drawn(valid)
    assert hatches == ["/////", "xxxxx"]
    assert "gray: rim, violet: unknown;" in caption
