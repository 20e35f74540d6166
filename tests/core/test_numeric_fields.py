"""The numbers of messages as arrays, and messages of such arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from graphnav import (
    FieldError,
    Image,
    Message,
    Plane,
    Steering,
    Stop,
    Twist,
    message_from,
    numeric_fields,
    numeric_layout,
)
from graphnav.core.codec import encode

PLANE = Plane(
    obstacle=np.eye(3, 4, dtype=np.uint8),
    score=np.linspace(0, 1, 12, dtype=np.float32).reshape(3, 4),
    valid=np.ones((3, 4), np.uint8),
    step_px=8,
    obstacle_ratio=0.25,
    threshold=0.5,
    converged=True,
)
STEERING = Steering(np.zeros(2), np.ones(2), np.array([0.25, 0.5]), 0.125, np.array([2.0, 1.0]))


def as_told(message: Message) -> dict[str, tuple[str, tuple[int, ...]]]:
    """Return the type and the shape of each array of a message."""
    return {name: (str(array.dtype), array.shape) for name, array in numeric_fields(message).items()}


def test_arrays_keep_their_shape_and_scalars_are_of_one_number() -> None:
    assert as_told(Twist(1.0, -0.5)) == {"v_mps": ("float32", (1,)), "omega_radps": ("float32", (1,))}
    plane = as_told(PLANE)
    assert plane["obstacle"] == ("uint8", (3, 4))
    assert plane["score"] == ("float32", (3, 4))
    assert plane["step_px"] == plane["converged"] == ("float32", (1,))


@pytest.mark.parametrize("shape", [(4, 5), (4, 5, 3)])
def test_a_picture_keeps_its_channels(shape: tuple[int, ...]) -> None:
    pixels = np.zeros(shape, np.uint8)
    assert numeric_fields(Image(pixels))["pixels"] is pixels


def test_floats_are_single() -> None:
    assert {dtype for dtype, _ in as_told(STEERING).values()} == {"float32"}


def test_text_is_left_out() -> None:
    assert list(numeric_fields(Stop(engaged=True, reason="a wall"))) == ["engaged"]
    assert [*numeric_layout(Stop)] == ["engaged"]


@pytest.mark.parametrize("message", [PLANE, STEERING, Twist(0.5, -0.25), Image(np.ones((2, 3, 3), np.uint8))])
def test_a_message_of_its_own_numbers_has_the_same_bytes(message: Message) -> None:
    assert encode(message_from(type(message), numeric_fields(message)), 7, 1) == encode(message, 7, 1)


def test_what_is_no_number_is_given_apart() -> None:
    stop = message_from(Stop, {"engaged": [0.5]}, reason="told so")
    assert (stop.engaged, stop.reason) == (True, "told so")


def test_integers_are_rounded_and_limited() -> None:
    pixels = message_from(Image, {"pixels": np.array([[-3.0, 0.6, 1e9]]), "step_px": [1.6]})
    assert pixels.pixels.tolist() == [[0, 1, 255]]
    assert pixels.pixels.dtype == np.uint8
    assert pixels.step_px == 2


@pytest.mark.parametrize(
    ("arrays", "told"),
    [
        ({"v_mps": [1.0]}, "omega_radps is missing, expected a value for every field of Twist"),
        ({"speed": [1.0]}, "speed is not a numeric field of Twist, expected v_mps, omega_radps"),
        ({"v_mps": [1.0, 2.0]}, "v_mps is of shape (2,), expected one number, of shape (1,)"),
        ({"v_mps": ["fast"]}, "v_mps is of <U4, expected numbers"),
    ],
)
def test_what_does_not_fit_is_told(arrays: dict[str, Any], told: str) -> None:
    with pytest.raises(FieldError) as error:
        message_from(Twist, arrays)
    assert str(error.value) == told


def test_an_integer_cannot_be_nan() -> None:
    with pytest.raises(FieldError, match=r"^pixels is NaN, expected a number that can be rounded$"):
        message_from(Image, {"pixels": np.array([[np.nan]])})
