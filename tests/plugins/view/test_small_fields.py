"""Fields that are too small for arrows, or for lines, are drawn without any."""

import numpy as np
import pytest
from graphnav_view import style
from graphnav_view.panels.keyframe import Frame
from graphnav_view.panels.potential_panels import draw_gradient, draw_potential

from graphnav import Potential


@pytest.mark.parametrize("shape", [(2, 100), (1, 1), (3, 300)])
def test_a_field_that_is_too_flat_has_no_arrows(shape: tuple[int, int]) -> None:
    potential = Potential(np.zeros(shape, np.float32), np.ones((*shape, 2), np.float32), step_px=4)
    frame = Frame(0, None, None, None, potential, None, None)
    axes = style.new_figure(4, 4).add_subplot()
    caption = draw_gradient(axes, frame)
    n_arrows = sum(np.shape(drawn.get_offsets())[0] for drawn in axes.collections)
    assert (n_arrows > 0) == (shape == (1, 1))
    assert caption.endswith("longest arrow 1.41 per cell" if n_arrows else "longest arrow 0.00 per cell")


def test_a_field_of_one_row_has_no_lines() -> None:
    row = np.arange(100, dtype=np.float32)[np.newaxis]
    frame = Frame(0, None, None, None, Potential(row, np.ones((1, 100, 2), np.float32), step_px=4), None, None)
    axes = style.new_figure(4, 4).add_subplot()
    assert "black 0.0, white 99.0" in draw_potential(axes, frame)
    assert not axes.collections
