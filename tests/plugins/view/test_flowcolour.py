"""Flow colours tell direction and length."""

import cv2
import numpy as np
from graphnav_view.flow_colour import INVALID, flow_rgb, flow_scale_px, wheel_rgb
from hypothesis import given
from hypothesis import strategies as st


def hue_deg(rgb: np.ndarray) -> int:
    return 2 * int(cv2.cvtColor(rgb.reshape(1, 1, 3), cv2.COLOR_RGB2HSV)[0, 0, 0])


@given(st.floats(0, 359), st.floats(1.0, 50.0))
def test_hue_is_the_direction_clockwise_from_right(angle_deg: float, length_px: float) -> None:
    angle = np.radians(angle_deg)
    uv = np.full((1, 1, 2), length_px * np.array([np.cos(angle), np.sin(angle)]), np.float32)
    off = (hue_deg(flow_rgb(uv, np.ones((1, 1)), length_px)) - angle_deg + 180) % 360 - 180
    assert abs(off) <= 4


def test_still_is_white_and_what_is_not_valid_gray() -> None:
    rgb = flow_rgb(np.zeros((1, 2, 2), np.float32), np.array([[1, 0]]), 1.0)
    assert rgb.tolist() == [[[255, 255, 255], [INVALID] * 3]]


def test_longer_is_more_colourful() -> None:
    uv = np.zeros((1, 4, 2), np.float32)
    uv[0, :, 0] = [0.0, 1.0, 2.0, 9.0]
    rgb = flow_rgb(uv, np.ones((1, 4)), 4.0)
    saturation = cv2.cvtColor(rgb, cv2.COLOR_RGB2HSV)[0, :, 1].astype(int)
    assert (np.diff(saturation) > 20).all()


def test_the_scale_ignores_what_is_not_valid() -> None:
    uv = np.ones((10, 10, 2), np.float32)
    uv[0] = 1000.0
    valid = np.ones((10, 10), np.uint8)
    valid[0] = 0
    assert flow_scale_px(uv, valid) == np.float32(np.sqrt(2))
    assert flow_scale_px(uv, np.zeros_like(valid)) == 0.1


def test_the_wheel_shows_the_same_colours() -> None:
    wheel, disc = wheel_rgb(65)
    assert disc[32, 64]
    assert not disc[0, 0]
    assert hue_deg(wheel[32, 63]) in range(-4, 5)
    assert abs(hue_deg(wheel[62, 32]) - 90) <= 4
