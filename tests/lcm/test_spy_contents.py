"""The contents of a message in few words."""

from __future__ import annotations

import json

import numpy as np
import pytest

from graphnav.core.field_summary import described, summarised
from graphnav.core.messages import Flow
from graphnav.watch.fields.plain_values import nested, plain

FLOW = Flow(
    uv_px=np.linspace(-1, 1, 24, dtype=np.float32).reshape(3, 4, 2),
    valid=np.array([[1, 1, 1, 0]] * 3, dtype=np.uint8),
    interval_us=100_000,
)


def test_few_numbers_are_said_as_they_are() -> None:
    summary = summarised({"force": np.array([0.5, -1.25])})
    assert summary["force"]["values"] == [0.5, -1.25]
    assert described(summary) == ["    force  [0.5, -1.25]"]


def test_arrays_are_summarised() -> None:
    summary = summarised({"uv_px": FLOW.uv_px, "valid": FLOW.valid, "empty": np.zeros((0, 3))})
    assert summary["uv_px"] == {"dtype": "float32", "shape": [3, 4, 2], "min": -1, "mean": pytest.approx(0), "max": 1}
    assert summary["valid"]["valid_ratio"] == 0.75
    assert summary["empty"] == {"dtype": "float64", "shape": [0, 3]}


def test_what_is_not_finite_is_left_out_and_said() -> None:
    summary = summarised({"depth_m": np.array([1, np.inf, np.nan, 3, np.nan, 2], np.float32), "x_m": float("nan")})
    assert summary["depth_m"] == {"dtype": "float32", "shape": [6], "finite_ratio": 0.5, "min": 1, "mean": 2, "max": 3}
    assert plain(summary)["x_m"] is None
    json.dumps(plain(summary), allow_nan=False)
    assert summarised({"all": np.full(3, np.nan)})["all"]["finite_ratio"] == 0


def test_a_person_reads_which_number_is_not_finite() -> None:
    values = {"a": float("nan"), "b": float("inf"), "c": -float("inf"), "few": np.array([1, np.nan, -np.inf])}
    said = ["    a    nan", "    b    inf", "    c    -inf", "    few  [1, nan, -inf]"]
    assert described(summarised(values)) == said
    assert described(nested(values)) == [*said[:3], "    few  [1.0, nan, -inf]"]


def test_texts_and_structs_are_short() -> None:
    summary = summarised({"text": "x" * 1000, "names": ("a", "b"), "one": {"p": np.zeros(2)}, "many": ({}, {})})
    assert summary["text"] == "x" * 60 + "... (1000 characters)"
    assert summary["names"] == {"dtype": "string", "shape": [2]}
    assert summary["many"] == {"dtype": "struct", "shape": [2]}
    assert summary["one"]["p"]["shape"] == [2]


def test_a_person_reads_one_line_a_field() -> None:
    lines = described(summarised({"uv_px": FLOW.uv_px, "valid": FLOW.valid, "converged": True, "mu": 0.5}))
    assert lines == [
        "    uv_px      float32 (3, 4, 2)  -1 to 1, mean 0",
        "    valid      uint8 (3, 4)  75.0 % valid",
        "    converged  True",
        "    mu         0.5",
    ]
