"""Limits that no base has are refused where they are received."""

from __future__ import annotations

from typing import Any

import pytest

from graphnav import BaseLimits, FieldError

GIVEN: dict[str, Any] = {
    "max_speed_mps": 0.8,
    "max_turn_radps": 2.0,
    "max_accel_mps2": 1.0,
    "max_decel_mps2": 1.2,
    "max_turn_accel_radps2": 6.0,
    "latency_s": 0.0,
}


def test_what_a_base_may_declare_is_read_as_it_is() -> None:
    assert vars(BaseLimits.from_lcm_fields(GIVEN)) == GIVEN


@pytest.mark.parametrize("field", [name for name in GIVEN if name != "latency_s"])
@pytest.mark.parametrize("value", [0.0, -1.0])
def test_a_base_that_cannot_move_or_brake_is_refused(field: str, value: float) -> None:
    with pytest.raises(FieldError, match=f"^{field} is {value:g}, expected more than 0$"):
        BaseLimits.from_lcm_fields(GIVEN | {field: value})


def test_no_command_acts_before_it_comes() -> None:
    with pytest.raises(FieldError, match=r"^latency_s is -0\.1, expected 0 or more$"):
        BaseLimits.from_lcm_fields(GIVEN | {"latency_s": -0.1})
