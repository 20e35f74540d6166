"""How a run ended is read off its last state."""

import numpy as np
import pytest
from graphnav_view.outcome import outcome_text

from graphnav import State


@pytest.mark.parametrize(
    ("contact", "at_goal", "end_s", "text"),
    [
        (False, True, 12.34, "Goal reached after 12.3 s"),
        (True, False, 3.0, "Contact after 3.0 s"),
        (True, True, 3.0, "Contact after 3.0 s"),
        (False, False, 60.0, "Time is up after 60.0 s"),
        (False, False, 31.0, "Ended after 31.0 s"),
    ],
)
def test_the_last_state_tells(contact: bool, at_goal: bool, end_s: float, text: str) -> None:
    last = State(
        x_m=0.0, y_m=0.0, yaw_rad=0.0, v_mps=0.0, omega_radps=0.0, clearance_m=0.1, contact=contact, at_goal=at_goal,
        moving=np.zeros((0, 3)),
    )  # fmt: skip
    assert outcome_text({"run": {"until_s": 60}}, last, end_s) == text
    assert outcome_text({}, last, end_s).startswith(text.split(maxsplit=1)[0]) or end_s == 60.0
