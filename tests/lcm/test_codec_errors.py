"""Values and bytes that do not fit a type give one clear error, never a crash or a huge allocation."""

from __future__ import annotations

import struct
import tracemalloc
from types import ModuleType
from typing import Any

import graphnav_lcm
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav.core.codec import DecodeError, EncodeError, codec_of, decode, encode
from graphnav.core.messages import Flow, Image, Twist

FLOW = Flow(uv_px=np.zeros((2, 3, 2), np.float32), valid=np.ones((2, 3), np.uint8), interval_us=100_000)
MAX_PEAK_BYTES = 1_000_000
"""Other threads of the process allocate too; the smallest of the absurd sizes would take 4 MB."""


def changed(**fields: Any) -> dict[str, Any]:
    """Return a flow's fields with some replaced."""
    return {**FLOW.lcm_fields(), "utime": 1, "seq": 2, **fields}


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        (
            {"uv_px": np.zeros((2, 3, 2))},
            "graphnav_lcm.flow_t.uv_px: expected float32, found float64",
        ),
        (
            {"uv_px": np.zeros((2, 4, 2), np.float32)},
            "graphnav_lcm.flow_t.valid: expected shape (rows=2, cols=4), found (2, 3)",
        ),
        (
            {"uv_px": np.zeros((2, 3, 3), np.float32)},
            "graphnav_lcm.flow_t.uv_px: expected shape (rows=2, cols=3, 2), found (2, 3, 3)",
        ),
        (
            {"uv_px": np.zeros((2, 3), np.float32)},
            "graphnav_lcm.flow_t.uv_px: expected 3 axes, found shape (2, 3)",
        ),
        ({"rows": 5}, "graphnav_lcm.flow_t.uv_px: expected shape (rows=5, cols, 2), found (2, 3, 2)"),
        ({"valid": [[1, 0, 256], [0, 0, 0]]}, "graphnav_lcm.flow_t.valid: expected uint8, found 0 to 256"),
        ({"valid": [[1, 0], [0]]}, "graphnav_lcm.flow_t.valid: ragged"),
        ({"valid": "110000"}, "graphnav_lcm.flow_t.valid: expected uint8, found str"),
        ({"valid": [[0.5, 0, 0], [0, 0, 0]]}, "graphnav_lcm.flow_t.valid: expected uint8, found float64"),
        ({"valid": None}, "graphnav_lcm.flow_t.valid: expected uint8, found object"),
        ({"step_px": 2**31}, "graphnav_lcm.flow_t.step_px: "),
        ({"step_px": 1.5}, "graphnav_lcm.flow_t.step_px: required argument is not an integer (found 1.5)"),
        ({"utime": None}, "graphnav_lcm.flow_t.utime: required argument is not an integer (found None)"),
        ({"speed": 1}, "graphnav_lcm.flow_t has no field speed"),
    ],
)
def test_what_does_not_fit_is_named(fields: dict[str, Any], text: str) -> None:
    with pytest.raises(EncodeError) as caught:
        codec_of(graphnav_lcm.flow_t).encode(changed(**fields))
    assert str(caught.value).startswith(text)


@pytest.mark.parametrize("name", ["utime", "valid", "interval_us"])
def test_a_missing_field_is_named(name: str) -> None:
    fields = changed()
    del fields[name]
    with pytest.raises(EncodeError, match=f"^graphnav_lcm.flow_t.{name} is missing$"):
        codec_of(graphnav_lcm.flow_t).encode(fields)


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"nothing": (), "words": [["a", 1]], "numbers": [[0, 0]]}, "words: expected str, found 1"),
        ({"nothing": (), "words": [["\ud800"]], "numbers": [[0]]}, "words: expected str"),
        ({"nothing": (), "words": [["a"], []], "numbers": [[0]]}, "words: ragged on axis 1: lengths \\[0, 1\\]"),
        ({"nothing": (), "words": ["ab"], "numbers": [[0, 0]]}, "words: expected a sequence on axis 1, found str"),
        ({"nothing": (1,), "words": [["a"]], "numbers": [[0]]}, "codec_types.empty_t: expected a mapping, found 1"),
    ],
)
def test_elements_that_do_not_fit_are_named(codec_types: ModuleType, fields: dict[str, Any], text: str) -> None:
    with pytest.raises(EncodeError, match=text):
        codec_of(codec_types.holder_t).encode(fields)


def test_a_float_too_large_for_its_type_is_refused(codec_types: ModuleType) -> None:
    codec = codec_of(codec_types.deep.inner_t)
    fields = {"id": 1, "fixed": (0, 0), "variable": [1e300], "name": "", "on": True}
    with pytest.raises(EncodeError, match=r"variable: expected float32, found 1e\+300"):
        codec.encode(fields)


def test_another_type_is_refused() -> None:
    with pytest.raises(DecodeError, match=r"not of type graphnav_lcm\.flow_t"):
        decode(Flow, encode(Twist(v_mps=0.1, omega_radps=0.2), 1, 2))


@settings(derandomize=True, deadline=None, max_examples=30)
@given(cut=st.integers(0, 200))
def test_a_message_cut_short_is_refused(cut: int) -> None:
    data = encode(FLOW, 1, 2)
    with pytest.raises(DecodeError):
        decode(Flow, data[: min(cut, len(data) - 1)])


def test_a_message_with_a_tail_is_refused() -> None:
    data = encode(FLOW, 1, 2)
    sizes = "where rows = [0-9]+, cols = [0-9]+$"
    with pytest.raises(DecodeError, match=f"of {len(data) + 1} bytes: its fields end at byte {len(data)} {sizes}"):
        decode(Flow, data + b"\0")


@settings(derandomize=True, deadline=None, max_examples=200)
@given(data=st.data())
def test_damaged_bytes_decode_or_are_refused(codec_types: ModuleType, data: st.DataObject) -> None:
    codec = codec_of(codec_types.holder_t)
    fields = {"nothing": [{}], "words": [["a", "bc"]], "numbers": [[1, 2]]}
    damaged = bytearray(codec.encode(fields))
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(8, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    try:
        values = codec.decode(bytes(damaged))
    except DecodeError:
        return
    assert codec.decode(codec.encode(values)).keys() == values.keys()


@pytest.mark.parametrize("size", [-1, 2**20, 2**31 - 1])
@pytest.mark.parametrize("place", ["rows", "cols"])
def test_absurd_sizes_take_no_memory(size: int, place: str) -> None:
    data = bytearray(encode(FLOW, 1, 2))
    struct.pack_into(">i", data, {"rows": 36, "cols": 40}[place], size)
    other = 40 if place == "rows" else 36
    for other_size in (0, 1, 2**31 - 1):
        struct.pack_into(">i", data, other, other_size)
        tracemalloc.start()
        with pytest.raises(DecodeError):
            decode(Flow, bytes(data))
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < MAX_PEAK_BYTES


@pytest.mark.parametrize(("n", "m", "k"), [(2**31 - 1, 0, 0), (0, 2**62, 0), (0, 2**62, 2**30), (0, 0, -5)])
def test_absurd_sizes_of_elements_take_no_memory(codec_types: ModuleType, n: int, m: int, k: int) -> None:
    codec = codec_of(codec_types.holder_t)
    data = codec.fingerprint + struct.pack(">iqi", n, m, k)
    tracemalloc.start()
    with pytest.raises(DecodeError):
        codec.decode(data)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < MAX_PEAK_BYTES


def test_nesting_beyond_reason_is_refused(codec_types: ModuleType) -> None:
    codec = codec_of(codec_types.tree_t)
    with pytest.raises(DecodeError, match="nested too deep"):
        codec.decode(codec.fingerprint + struct.pack(">ii", 1, 1) * 100_000)


def test_a_picture_whose_sizes_contradict_is_refused() -> None:
    codec = codec_of(graphnav_lcm.image_t)
    fields = {"utime": 0, "seq": 0, "step_px": 1, "rows": 3, "cols": 5, "channels": 1, "data": bytes(7)}
    with pytest.raises(DecodeError, match="not of type Image"):
        decode(Image, codec.encode(fields))


def test_a_string_that_is_no_utf8_is_replaced_as_lcm_gen_does(codec_types: ModuleType) -> None:
    codec = codec_of(codec_types.deep.inner_t)
    data = codec.encode({"id": 1, "fixed": (0, 0), "variable": [], "name": "ab", "on": False})
    damaged = data.replace(b"ab", b"\xff\xfe")
    assert codec.decode(damaged)["name"] == codec_types.deep.inner_t.decode(damaged).name
