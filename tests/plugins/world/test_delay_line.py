"""Values come back a constant time later."""

from __future__ import annotations

import math

from graphnav_world.delay_line import DelayLine


def test_values_are_due_in_their_order_a_constant_time_later() -> None:
    line: DelayLine[str] = DelayLine(250)
    line.put("a", 0)
    line.put("b", 100)
    assert line.next_us == 250
    assert line.due(249) == []
    assert line.due(400) == [(250, "a"), (350, "b")]
    assert line.due(400) == []
    assert line.next_us == math.inf


def test_without_a_delay_a_value_is_due_at_once() -> None:
    line: DelayLine[int] = DelayLine(0)
    line.put(7, 30)
    assert line.due(30) == [(30, 7)]
