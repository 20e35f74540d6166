"""Peeking and checking messages without decoding agrees with decoding."""

from __future__ import annotations

from types import ModuleType

import graphnav_lcm
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav.core.codec import SHIPPED, DecodeError, codec_of, encode, fields_of
from graphnav.core.messages import Twist

from .test_codec import NAMES, objects


def decodes(lcm_class: type, data: bytes) -> bool:
    """Return whether the decoder takes the bytes."""
    try:
        codec_of(lcm_class).decode(data)
    except DecodeError:
        return False
    return True


@st.composite
def damaged(draw: st.DrawFn, data: bytes) -> bytes:
    """Draw a message that was cut, lengthened or flipped in places, or left as it is."""
    at = draw(st.integers(0, len(data)))
    how = draw(st.sampled_from(["whole", "cut", "longer", "flipped", "swapped"]))
    if how == "cut":
        return data[:at]
    if how == "longer":
        return data + draw(st.binary(min_size=1, max_size=9))
    if how == "flipped":
        changed = bytearray(data)
        for place in draw(st.lists(st.integers(0, len(data) - 1), min_size=1, max_size=4)):
            changed[place] ^= 1 << draw(st.integers(0, 7))
        return bytes(changed)
    return data[at:] + data[:at] if how == "swapped" else data


@pytest.mark.parametrize("name", NAMES)
@settings(derandomize=True, deadline=None, max_examples=150)
@given(data=st.data())
def test_a_message_fits_if_and_only_if_it_decodes(codec_types: ModuleType, name: str, data: st.DataObject) -> None:
    lcm_class = getattr(codec_types, name)
    message = data.draw(damaged(data.draw(objects(lcm_class)).encode()))
    assert codec_of(lcm_class).fits(message) is decodes(lcm_class, message)


@pytest.mark.parametrize("lcm_class", SHIPPED, ids=lambda lcm_class: lcm_class.__name__)
@settings(derandomize=True, deadline=None, max_examples=60)
@given(data=st.data())
def test_the_types_that_ship_are_measured_alike(lcm_class: type, data: st.DataObject) -> None:
    message = data.draw(damaged(data.draw(objects(lcm_class)).encode()))
    assert codec_of(lcm_class).fits(message) is decodes(lcm_class, message)


@pytest.mark.parametrize("name", NAMES)
@settings(derandomize=True, deadline=None, max_examples=40)
@given(data=st.data())
def test_what_is_peeked_at_is_what_is_decoded(codec_types: ModuleType, name: str, data: st.DataObject) -> None:
    lcm_class = getattr(codec_types, name)
    message = data.draw(objects(lcm_class)).encode()
    codec = codec_of(lcm_class)
    decoded = codec.decode(message)
    for field in fields_of(lcm_class):
        value = decoded[field.name]
        assert codec.peek(message, field.name) == (value if isinstance(value, int) else None)
    assert codec.peek(message, "no such field") is None


def test_stamp_and_number_of_ours_are_peeked_at() -> None:
    data = encode(Twist(0.1, 0.2), 123, 45)
    codec = codec_of(graphnav_lcm.twist_t)
    assert (codec.peek(data, "utime"), codec.peek(data, "seq")) == (123, 45)
