"""A message class has the fields of its LCM type, or the stages that use it are refused."""

import graphnav_lcm
import numpy as np
import numpy.typing as npt
import pytest

from graphnav.core.codec import check_fields, message_classes
from graphnav.core.errors import DeclarationError
from graphnav.core.messages import Message
from graphnav.core.stage import Stage, ports_of


class OtherNames(Message, lcm=graphnav_lcm.twist_t):
    """A speed under another name."""

    v_mps: float
    turn_radps: float


class TextForNumber(Message, lcm=graphnav_lcm.twist_t):
    """A string where the type has a number."""

    v_mps: str
    omega_radps: float


class ScalarForArray(Message, lcm=graphnav_lcm.flow_t):
    """A number where the type has an array, and doubles where it has floats."""

    uv_px: npt.NDArray[np.float64]
    valid: int
    interval_us: float
    step_px: int = 1


class Converted(Message, lcm=graphnav_lcm.twist_t):
    """Converts its fields itself."""

    speed_mps: float

    def lcm_fields(self) -> dict[str, float]:
        return {"v_mps": self.speed_mps, "omega_radps": 0.0}


TOLD = {
    OtherNames: "message OtherNames has the fields v_mps, turn_radps, but its LCM type graphnav_lcm.twist_t has v_mps, "
    "omega_radps",
    TextForNumber: "message TextForNumber does not hold what its LCM type graphnav_lcm.twist_t does: 'v_mps' is str "
    "for double",
    ScalarForArray: "message ScalarForArray does not hold what its LCM type graphnav_lcm.flow_t does: 'interval_us' is "
    "float for int64_t, 'uv_px' is an array of float64 for float[rows][cols][2], 'valid' is int for byte[rows][cols]",
}


@pytest.mark.parametrize("message", TOLD, ids=lambda message: message.__name__)
def test_other_fields_are_refused_with_both_lists(message: type[Message]) -> None:
    with pytest.raises(DeclarationError) as caught:
        check_fields(message)
    assert str(caught.value) == TOLD[message]


def test_a_stage_that_uses_it_is_refused() -> None:
    class Reads(Stage):
        def step(self, twist: OtherNames) -> None: ...

    with pytest.raises(DeclarationError, match="has the fields v_mps, turn_radps"):
        ports_of(Reads)


def test_fields_that_a_class_converts_are_its_own() -> None:
    check_fields(Converted)


def test_every_message_has_the_fields_of_its_type() -> None:
    for message in message_classes():
        if message.__module__.startswith("graphnav"):  # tests declare others
            check_fields(message)
