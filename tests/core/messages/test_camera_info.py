"""Parameters of cameras that are not calibrated, or of models that are not known, are refused where they come in."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from graphnav import CameraInfo, FieldError
from graphnav.core.codec import decode, encode

GIVEN: dict[str, Any] = {
    "rows": 120,
    "cols": 160,
    "model": "plumb_bob",
    "camera": np.array([[114.0, 0.0, 79.5], [0.0, 114.0, 59.5], [0.0, 0.0, 1.0]]),
    "distortion": np.array([-0.2, 0.04, 0.0, 0.0, 0.0]),
    "rectification": np.eye(3),
    "projection": np.eye(3, 4),
}


def test_it_comes_back() -> None:
    info = CameraInfo.from_lcm_fields(GIVEN)
    back = decode(CameraInfo, encode(info, 5, 6))[2]
    assert all(map(np.array_equal, vars(back).values(), GIVEN.values()))


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"model": "guess"}, "model is 'guess', expected plumb_bob, rational_polynomial, equidistant"),
        ({"distortion": np.zeros(3)}, "size of distortion is 3, expected 0 or 4 or 5 numbers"),
        ({"camera": np.zeros((3, 3))}, "focal length is 0, expected more than 0: calibrate the camera"),
    ],
)
def test_a_camera_that_is_not_calibrated_is_refused(changed: dict[str, Any], told: str) -> None:
    with pytest.raises(FieldError) as error:
        CameraInfo.from_lcm_fields(GIVEN | changed)
    assert str(error.value) == told
