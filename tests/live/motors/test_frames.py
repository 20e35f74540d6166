"""Frames come out of the pipe as they went in, however it cuts them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphnav.live.motors.frames import MAX_PAYLOAD_BYTES, Frame, FrameReader, Kind, pack

frames = st.builds(Frame, st.sampled_from(Kind), st.integers(0, 65_535), st.floats(0.0, 1e9), st.binary(max_size=200))


def packed(frame: Frame) -> bytes:
    return pack(Kind(frame.kind), *frame[1:])


@given(sent=st.lists(frames, max_size=10), size=st.integers(1, 300))
def test_frames_survive_any_cut(sent: list[Frame], size: int) -> None:
    data, reader, got = b"".join(map(packed, sent)), FrameReader(), list[Frame]()
    for start in range(0, len(data), size):
        got += reader.feed(data[start : start + size])
    assert got == sent


@given(frame=frames, n_bytes=st.integers(1, 300))
def test_an_incomplete_frame_does_not_come_out(frame: Frame, n_bytes: int) -> None:
    data = packed(frame)
    reader = FrameReader()
    assert reader.feed(packed(frame) + data[: min(n_bytes, len(data) - 1)]) == [frame]


def test_what_is_not_a_frame_is_refused() -> None:
    with pytest.raises(ValueError, match="expected at most"):
        FrameReader().feed(b"\xff" * 30)
    assert FrameReader().feed(pack(Kind.COMMAND, 0, 0.0, bytes(MAX_PAYLOAD_BYTES)))
