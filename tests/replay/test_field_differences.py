"""Messages are compared field by field, exactly or within a tolerance."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from graphnav.replay.comparison.field_differences import Difference, Tolerance, field_differences

EXACT = Tolerance()
floats = st.floats(width=32, allow_nan=True)
arrays = hnp.arrays(np.float32, hnp.array_shapes(max_dims=3, max_side=4), elements=floats)


@settings(derandomize=True, deadline=None)
@given(array=arrays, number=floats, text=st.text())
def test_equal_messages_do_not_differ(array: Any, number: float, text: str) -> None:
    fields = {"a": array, "n": number, "t": text, "seq": 1, "s": ({"x": number, "y": (text,)},)}
    other = {**fields, "a": array.copy(), "seq": 2}
    assert field_differences(fields, other, EXACT) == {}
    assert field_differences(fields, other, Tolerance(1.0, 1.0)) == {}


@settings(derandomize=True, deadline=None)
@given(array=hnp.arrays(np.uint8, hnp.array_shapes(max_dims=3, max_side=4)), data=st.data())
def test_one_element_that_changed_is_found(array: Any, data: Any) -> None:
    index = tuple(data.draw(st.integers(0, size - 1)) for size in array.shape)
    other = array.copy()
    other[index] ^= 0x80
    found = field_differences({"a": array}, {"a": other}, EXACT)
    assert found == {"a": Difference(index, array[index].item(), other[index].item(), 128.0)}
    assert field_differences({"a": array}, {"a": other}, Tolerance(127.0)) == found
    assert field_differences({"a": array}, {"a": other}, Tolerance(128.0)) == {}


@pytest.mark.parametrize(
    ("recorded", "replayed", "found"),
    [
        (1.0, 1.5, Difference((), 1.0, 1.5, 0.5)),
        (1, 3, Difference((), 1, 3, 2.0)),
        (True, False, Difference((), True, False, 1.0)),
        ("goal", "end", Difference((), "goal", "end", None)),
        (math.nan, 1.0, Difference((), math.nan, 1.0, math.inf)),
        (1.0, math.inf, Difference((), 1.0, math.inf, math.inf)),
        (("a", "b"), ("a", "c"), Difference((1,), "b", "c", None)),
        (("a",), (), Difference((), "1 entries", "0 entries", None)),
        (np.zeros((2, 3)), np.zeros((3, 2)), Difference((), "shape (2, 3)", "shape (3, 2)", None)),
        (np.array([0.0, math.inf]), np.array([0.0, -math.inf]), Difference((1,), math.inf, -math.inf, math.inf)),
        (np.array([1.0, math.nan]), np.array([2.0, 0.0]), Difference((0,), 1.0, 2.0, math.inf)),
        (np.array([["a"], ["b"]], object), np.array([["a"], ["x"]], object), Difference((1, 0), "b", "x", None)),
    ],
)
def test_what_differs_is_told(recorded: Any, replayed: Any, found: Difference) -> None:
    assert repr(field_differences({"f": recorded}, {"f": replayed}, EXACT)) == repr({"f": found})


def test_nested_fields_are_named_and_elements_of_one_field_are_merged() -> None:
    recorded = {"s": ({"x": 1.0, "n": "a"}, {"x": 2.0, "n": "b"})}
    replayed = {"s": ({"x": 1.5, "n": "a"}, {"x": 4.0, "n": "c"})}
    assert field_differences(recorded, replayed, EXACT) == {
        "s.x": Difference((0,), 1.0, 1.5, 2.0),
        "s.n": Difference((1,), "b", "c", None),
    }


@settings(derandomize=True, deadline=None)
@given(old=arrays, shift=st.floats(-2, 2), max_abs=st.floats(0, 1), max_rel=st.floats(0, 1))
def test_the_tolerance_is_that_of_each_element(old: Any, shift: float, max_abs: float, max_rel: float) -> None:
    new = (old + np.float32(shift)).astype(np.float32)
    found = field_differences({"a": old}, {"a": new}, Tolerance(max_abs, max_rel))
    one, other = old.astype(np.float64).ravel(), new.astype(np.float64).ravel()
    apart = [
        not (a == b or (math.isnan(a) and math.isnan(b)) or abs(a - b) <= max_abs + max_rel * abs(a))
        for a, b in zip(one, other, strict=True)
    ]
    assert bool(found) == any(apart)
    if found:
        assert np.ravel_multi_index(found["a"].where, old.shape) == apart.index(True)


@settings(derandomize=True, deadline=None)
@given(data=st.binary(min_size=32, max_size=32))
def test_any_bytes_are_compared_without_a_warning(data: bytes) -> None:
    for kind in (np.float32, np.float64, np.int64):
        old = np.frombuffer(data, kind)
        found = field_differences({"a": old}, {"a": old[::-1]}, Tolerance(1.0, 0.5))
        assert found.keys() <= {"a"}
    quiet, signaling = (np.array([bits], np.uint32).view(np.float32) for bits in (0x7FC00000, 0x7F800001))
    assert field_differences({"a": quiet}, {"a": signaling}, EXACT) == {}
    assert field_differences({"a": np.array([1e308])}, {"a": np.array([-1e308])}, EXACT)["a"].gap == math.inf
