"""The codec's bytes are lcm-gen's, for every type, in both directions."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav.core.codec import codec_of

NUMPY = {"int8_t": "i1", "int16_t": "i2", "int32_t": "i4", "int64_t": "i8", "byte": "u1", "float": "f4", "double": "f8"}
NUMPY["boolean"] = "?"
NAMES = ("every_t", "holder_t", "tree_t", "empty_t")

SCALARS: dict[str, st.SearchStrategy[Any]] = {
    "int8_t": st.integers(-(2**7), 2**7 - 1),
    "int16_t": st.integers(-(2**15), 2**15 - 1),
    "int32_t": st.integers(-(2**31), 2**31 - 1),
    "int64_t": st.integers(-(2**63), 2**63 - 1),
    "byte": st.integers(0, 255),
    "float": st.floats(width=32, allow_nan=False),
    "double": st.floats(allow_nan=False),
    "boolean": st.booleans(),
    "string": st.text(st.characters(exclude_categories=["Cs"]), max_size=5),
}


def struct_class(lcm_class: Any, typename: str) -> Any:
    """Return the class of a nested type."""
    package, _, name = typename.rpartition(".")
    return lcm_class if name == lcm_class.__name__ else getattr(sys.modules[package], name)


def columns(lcm_class: Any) -> list[tuple[str, str, list[Any]]]:
    """Return name, type and dimensions of each field."""
    slots, types, dims = lcm_class.__slots__, lcm_class.__typenames__, lcm_class.__dimensions__
    return [(name, typename, list(d or ())) for name, typename, d in zip(slots, types, dims, strict=True)]


def nested(draw: st.DrawFn, element: Any, typename: str, shape: list[int]) -> Any:
    """Draw what lcm-gen's encoder wants for an array."""
    if not shape:
        return element()
    if typename == "byte" and len(shape) == 1:
        return draw(st.binary(min_size=shape[0], max_size=shape[0]))
    return [nested(draw, element, typename, shape[1:]) for _ in range(shape[0])]


@st.composite
def objects(draw: st.DrawFn, lcm_class: Any, depth: int = 0) -> Any:
    """Draw an instance of an lcm-gen class."""
    made = lcm_class()
    sizes = {dim for _, _, dims in columns(lcm_class) for dim in dims if isinstance(dim, str)}
    for name, typename, dims in columns(lcm_class):
        if name in sizes:
            setattr(made, name, draw(st.integers(0, 3 if depth < 2 else 0)))
            continue

        def element(typename: str = typename) -> Any:
            scalar = SCALARS.get(typename)
            return draw(scalar if scalar is not None else objects(struct_class(lcm_class, typename), depth + 1))

        shape = [getattr(made, dim) if isinstance(dim, str) else dim for dim in dims]
        setattr(made, name, nested(draw, element, typename, shape))
    return made


def as_fields(made: Any, *, sizes: bool) -> dict[str, Any]:
    """Return an lcm-gen object as the codec takes it: numpy arrays, dicts; array sizes only if asked."""
    fields: dict[str, Any] = {}
    told = {dim for _, _, dims in columns(type(made)) for dim in dims if isinstance(dim, str)}
    for name, typename, dims in columns(type(made)):
        value = getattr(made, name)
        if name in told and not sizes:
            continue
        if not dims:
            fields[name] = value if typename in SCALARS else as_fields(value, sizes=sizes)
            continue
        shape = [getattr(made, dim) if isinstance(dim, str) else dim for dim in dims]
        flat = [value]
        for _ in shape:
            flat = [x for part in flat for x in part]
        if typename not in SCALARS:
            flat = [as_fields(x, sizes=sizes) for x in flat]
        array = np.empty(len(flat), NUMPY.get(typename, object))
        array[:] = flat
        fields[name] = array.reshape(shape)
    return fields


def assert_same(decoded: Any, made: Any) -> None:
    """Check every field of a decoded struct against the lcm-gen object."""
    assert list(decoded) == made.__slots__
    for name, typename, dims in columns(type(made)):
        value, expected = decoded[name], getattr(made, name)
        if typename in NUMPY and dims:
            wanted = as_fields(made, sizes=True)[name]
            assert value.dtype == wanted.dtype
            assert value.dtype.isnative
            assert not value.flags.writeable
            np.testing.assert_array_equal(value, wanted, strict=True)
        elif typename in SCALARS and not dims:
            assert value == expected
            assert type(value) is type(expected)
        else:
            values, wanted = [value], [expected]
            for _ in dims:
                values, wanted = [x for part in values for x in part], [x for part in wanted for x in part]
            assert len(values) == len(wanted)
            for one, other in zip(values, wanted, strict=True):
                if typename in SCALARS:
                    assert one == other
                else:
                    assert_same(one, other)


@pytest.mark.parametrize("name", NAMES)
@settings(derandomize=True, deadline=None, max_examples=60)
@given(data=st.data())
def test_bytes_are_those_of_lcm_gen(codec_types: ModuleType, name: str, data: st.DataObject) -> None:
    lcm_class = getattr(codec_types, name)
    made = data.draw(objects(lcm_class))
    theirs = made.encode()
    codec = codec_of(lcm_class)

    assert codec.encode(as_fields(made, sizes=True)) == theirs
    assert codec.encode(as_fields(made, sizes=False)) == theirs

    decoded = codec.decode(theirs)
    assert_same(decoded, made)
    assert codec.encode(decoded) == theirs


def test_ready_made_lists_are_taken_like_arrays(codec_types: ModuleType) -> None:
    codec = codec_of(codec_types.holder_t)
    lists = {"nothing": [{}, {}], "words": [["a", "b"]], "numbers": [[1, 2.5]]}
    decoded = codec.decode(codec.encode(lists))
    assert (decoded["n"], decoded["m"], decoded["k"]) == (2, 1, 2)
    assert decoded["numbers"].tolist() == [[1.0, 2.5]]
    assert decoded["words"].tolist() == [["a", "b"]]
    assert decoded["nothing"] == ({}, {})


def test_an_empty_list_leaves_the_hidden_size_open(codec_types: ModuleType) -> None:
    codec = codec_of(codec_types.holder_t)
    decoded = codec.decode(codec.encode({"nothing": [], "words": [], "numbers": np.zeros((0, 7))}))
    assert (decoded["m"], decoded["k"]) == (0, 7)
    assert decoded["words"].shape == (0, 7)


@pytest.mark.parametrize("order", ["C", "F"])
def test_any_memory_layout_is_taken(codec_types: ModuleType, order: Any) -> None:
    codec = codec_of(codec_types.holder_t)
    plain = np.arange(24.0).reshape(4, 6)
    wanted = codec.encode({"nothing": (), "words": np.full((2, 3), ""), "numbers": plain[::2, ::2].copy()})
    strided = np.asarray(plain, order=order)[::2, ::2]
    swapped = strided.astype(">f8")
    narrow = strided.astype(np.float32)
    for array in (strided, swapped, narrow):
        assert codec.encode({"nothing": (), "words": np.full((2, 3), ""), "numbers": array}) == wanted


def test_nan_and_infinity_keep_their_bits(codec_types: ModuleType) -> None:
    codec = codec_of(codec_types.holder_t)
    odd = np.array([[np.nan, np.inf, -np.inf, -0.0]])
    decoded = codec.decode(codec.encode({"nothing": (), "words": np.full((1, 4), "x"), "numbers": odd}))
    assert decoded["numbers"].tobytes() == odd.tobytes()


def test_bytes_arrays_are_views_of_the_message(codec_types: ModuleType) -> None:
    import graphnav_lcm

    codec = codec_of(graphnav_lcm.image_t)
    image = np.arange(12, dtype=np.uint8)
    fields = {"utime": 1, "seq": 2, "step_px": 1, "rows": 3, "cols": 4, "channels": 1, "data": image}
    data = codec.encode(fields)
    assert np.shares_memory(codec.decode(data)["data"], np.frombuffer(data, np.uint8))
    assert codec.encode({**fields, "data": image.tobytes()}) == data
