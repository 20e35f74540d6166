"""How a run ended is read off its last state."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from graphnav_view.outcome import drive_texts, outcome_text
from graphnav_view.signals import Signals
from graphnav_view.track import track_of

from graphnav import Map, Recording, State


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


def test_the_clearance_is_told_where_there_is_something_to_be_clear_of(record: Callable[..., Recording]) -> None:
    signals = Signals(record(frames=40))
    world, track = signals.first(Map), track_of(signals)
    assert world is not None
    assert track is not None
    path, clearance = drive_texts(world, track)
    assert path.startswith("path 1.")
    assert clearance == "minimum clearance 0.20 m after the first metre"
    empty = replace(world, kind=world.kind[:0], height_m=world.height_m[:0], vertices_m=world.vertices_m[:0])
    assert drive_texts(empty, track) == [path]


def test_what_is_near_the_start_is_not_told_as_the_clearance(record: Callable[..., Recording]) -> None:
    signals = Signals(record(frames=3))
    world, track = signals.first(Map), track_of(signals)
    assert world is not None
    assert track is not None
    assert len(drive_texts(world, track)) == 1, "the robot has driven less than a metre"
