"""Fields on the command line: YAML in, a complete message out; every mistake has its place and its text."""

from __future__ import annotations

from typing import Any

import graphnav_lcm
import numpy as np
import pytest

from graphnav.core.codec import SHIPPED, codec_of, lcm_name
from graphnav.core.errors import UserError
from graphnav.live.publish import parse_fields


def sent(text: str, lcm_class: type) -> dict[str, Any]:
    """Return what a receiver decodes."""
    return codec_of(lcm_class).decode(codec_of(lcm_class).encode(parse_fields(text, lcm_class).values))


@pytest.mark.parametrize(
    "text",
    [
        "v_mps: 0.2, omega_radps: -1",
        "{v_mps: 0.2, omega_radps: -1}",
        "v_mps: 0.2\nomega_radps: -1",
        "  v_mps: 2e-1, omega_radps: -1.0  # slowly",
    ],
)
def test_one_line_needs_no_braces(text: str) -> None:
    fields = parse_fields(text, graphnav_lcm.twist_t)
    assert fields.values == {"utime": 0, "seq": 0, "v_mps": 0.2, "omega_radps": -1.0}
    assert fields.given == {"v_mps", "omega_radps"}


@pytest.mark.parametrize("lcm_class", SHIPPED, ids=lcm_name)
def test_what_is_not_given_is_zero_or_empty(lcm_class: type) -> None:
    made: Any = lcm_class()
    codec = codec_of(lcm_class)
    assert codec.encode(parse_fields("", lcm_class).values) == made.encode()


def test_arrays_and_nested_structs_are_written_as_yaml() -> None:
    values = sent("stages: [{name: flow, rate_hz: 10}, {name: 'on'}], live: true", graphnav_lcm.status_t)
    assert [stage["name"] for stage in values["stages"]] == ["flow", "on"]
    assert values["stages"][0]["rate_hz"] == 10.0
    assert (values["n_stages"], values["n_edges"], values["live"]) == (2, 0, True)


def test_an_array_gives_the_others_their_size() -> None:
    values = sent("valid: [[1, 0, 1], [1, 1, 1]]", graphnav_lcm.flow_t)
    assert (values["rows"], values["cols"], values["uv_px"].shape) == (2, 3, (2, 3, 2))
    assert np.array_equal(values["valid"], [[1, 0, 1], [1, 1, 1]])
    assert sent("rows: 4, cols: 5", graphnav_lcm.flow_t)["valid"].shape == (4, 5)


@pytest.mark.parametrize(
    ("lcm_class", "text", "said"),
    [
        ("twist_t", "v_mp: 1", "FIELDS:1:1: graphnav_lcm.twist_t has no field 'v_mp'\n  did you mean 'v_mps'?"),
        (
            "twist_t",
            "speed: 1",
            "FIELDS:1:1: graphnav_lcm.twist_t has no field 'speed'\n  fields are utime, seq, v_mps, omega_radps",
        ),
        (
            "twist_t",
            "v_mps: fast, omega_radps: .nan",
            (
                "FIELDS:1:8: 'v_mps' must be a number (double), not the string 'fast'\n  write a number\n"
                "FIELDS:1:27: 'omega_radps' is not finite: nan\n  write a finite number"
            ),
        ),
        (
            "twist_t",
            "5",
            (
                "FIELDS must be a mapping, not the number 5\n"
                "  write name: value; fields are utime, seq, v_mps, omega_radps"
            ),
        ),
        (
            "stop_t",
            "[now]",
            ("FIELDS must be a mapping, not a list\n  write name: value; fields are utime, seq, engaged, reason"),
        ),
        ("twist_t", "{v_mps: .inf}", "FIELDS:1:9: 'v_mps' is not finite: inf\n  write a finite number"),
        ("twist_t", "v_mps: true", "FIELDS:1:8: 'v_mps' must be a number (double), not true\n  write a number"),
        (
            "twist_t",
            "seq: 9223372036854775808",
            (
                "FIELDS:1:6: 'seq' is 9223372036854775808, but the range of int64_t is -9223372036854775808 to "
                "9223372036854775807\n"
                "  write an integer in this range"
            ),
        ),
        (
            "twist_t",
            "seq: 1.0",
            "FIELDS:1:6: 'seq' must be an integer (int64_t), not the number 1.0\n  write an integer",
        ),
        (
            "stop_t",
            "reason: 5, engaged: 1",
            (
                "FIELDS:1:9: 'reason' must be a string, not the number 5\n  put it in quotes\n"
                "FIELDS:1:21: 'engaged' must be a boolean, not the number 1\n  write true or false"
            ),
        ),
        (
            "flow_t",
            "valid: [[1, 256]]",
            "FIELDS:1:13: 'valid' is 256, but the range of byte is 0 to 255\n  write an integer in this range",
        ),
        (
            "flow_t",
            "uv_px: [[[1e39, 0]]]",
            "FIELDS:1:11: 'uv_px' is 1e+39, but the maximum of float is 3.40282e+38\n  write a smaller number",
        ),
        (
            "flow_t",
            "valid: 1",
            "FIELDS:1:8: 'valid' must be an array byte[rows][cols], not the number 1\n  write [[value]]",
        ),
        (
            "flow_t",
            "valid: [[1, 2], [3]]",
            "FIELDS:1:1: the lists in 'valid' differ in length\n  make them equal",
        ),
        ("flow_t", "uv_px: [[[1]]]", "FIELDS:1:10: 'uv_px' must hold 2 values here, not 1\n  write 2 values"),
        (
            "flow_t",
            "rows: 3, valid: [[1]]",
            (
                "FIELDS: graphnav_lcm.flow_t.valid: expected shape (rows=3, cols=1), found (1, 1)\n"
                "  give arrays the sizes that the type declares"
            ),
        ),
        (
            "flow_t",
            "rows: 100000, cols: 100000",
            "FIELDS:1:1: 'uv_px' would have the shape [100000, 100000, 2]\n  write smaller sizes",
        ),
        (
            "flow_t",
            "rows: -1",
            "FIELDS:1:1: 'uv_px' would have the shape [-1, 0, 2]\n  write smaller sizes",
        ),
        (
            "status_t",
            "stages: [{nam: x}]",
            "FIELDS:1:11: graphnav_lcm.stage_status_t has no field 'nam'\n  did you mean 'name'?",
        ),
        (
            "status_t",
            "stages: [x]",
            (
                "FIELDS:1:10: graphnav_lcm.stage_status_t needs fields, not the string 'x'\n"
                "  write name: value, name: value"
            ),
        ),
        (
            "twist_t",
            "v_mps: 1, v_mps: 2",
            "FIELDS:1:11: duplicate entry 'v_mps', first in line 1\n  keep one",
        ),
        ("twist_t", "v_mps: [1", "FIELDS: the '[' of line 1 is not closed\n  write ']' or a comma before this"),
    ],
)
def test_a_mistake_is_said_with_its_place(lcm_class: str, text: str, said: str) -> None:
    with pytest.raises(UserError) as caught:
        parse_fields(text, getattr(graphnav_lcm, lcm_class))
    assert str(caught.value) == said


@pytest.mark.parametrize(
    "text", ["v_mps", "[1]", "1", "'", "{", "{}}", "- a\n- b", "a: b: c", "? x", "&a [*a]", "\udcff: 1", '"\\ud800": 1']
)
def test_whatever_is_written_there_is_no_traceback(text: str) -> None:
    for lcm_class in (graphnav_lcm.twist_t, graphnav_lcm.flow_t):
        with pytest.raises(UserError):
            parse_fields(text, lcm_class)
