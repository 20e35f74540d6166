"""The graphics protocol of kitty: what is sent is the picture."""

from __future__ import annotations

import base64
import re
import zlib

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from graphnav.arrays import Bytes
from graphnav.watch.spy.screen.painters.kitty_painter import delete, put

_SEQUENCE = re.compile(r"\x1b_G([^;]*)(?:;([A-Za-z0-9+/=]*))?\x1b\\")
_CHUNK = 4096


def keys_of(text: str) -> dict[str, str]:
    """Return the keys of a sequence with their values."""
    return dict(pair.split("=") for pair in text.split(","))


@given(arrays(np.uint8, st.tuples(st.integers(1, 60), st.integers(1, 60), st.just(3))), st.integers(1, 2**32 - 1))
def test_the_pixels_arrive_in_chunks(picture: Bytes, image_id: int) -> None:
    sent = put(picture, image_id, 7, 9)
    sequences = [found.groups() for found in _SEQUENCE.finditer(sent)]
    assert "".join(f"\x1b_G{keys};{data}\x1b\\" for keys, data in sequences) == sent
    first, *others = [keys_of(keys) for keys, _ in sequences]
    assert [keys["m"] for keys in (first, *others)] == ["1"] * len(others) + ["0"]
    assert all(set(keys) == {"m"} for keys in others)
    assert all(len(data) <= _CHUNK for _, data in sequences)
    assert (first["a"], first["q"], first["C"]) == ("T", "2", "1"), "shown, no answer, the cursor stays"
    assert (first["i"], first["r"], first["c"]) == (str(image_id), "7", "9")
    pixels = zlib.decompress(base64.b64decode("".join(data for _, data in sequences)))
    assert np.array_equal(np.frombuffer(pixels, np.uint8).reshape(int(first["v"]), int(first["s"]), 3), picture)


def test_an_image_is_deleted_with_its_data() -> None:
    (found,) = _SEQUENCE.finditer(delete(5))
    assert keys_of(found[1]) == {"a": "d", "d": "I", "q": "2", "i": "5"}
