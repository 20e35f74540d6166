"""Files that declare more than there can be: the error is the file's, at once and in words of the file."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import pytest
from graphnav_io.capture import interruptible, open_capture
from graphnav_io.images import Images
from graphnav_io.pictures import read_picture
from graphnav_io.video import Video

from graphnav import ParamError


def png(cols: int, rows: int) -> bytes:
    """Return a PNG that declares a size, with almost no pixels."""
    chunks = [
        (b"IHDR", struct.pack(">IIBBBBB", cols, rows, 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(b"0")),
        (b"IEND", b""),
    ]
    parts = [struct.pack(">I", len(d)) + n + d + struct.pack(">I", zlib.crc32(n + d)) for n, d in chunks]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


@pytest.mark.parametrize("side", [8001, 12000, 40_000, 100_000])
def test_a_picture_of_impossible_size_is_not_decoded(side: int, tmp_path: Path) -> None:
    (tmp_path / "1.png").write_bytes(png(side, side))
    with pytest.raises(ValueError, match=r"'.*1\.png' is too large a picture: .* 64 million"):
        read_picture(tmp_path / "1.png")
    with pytest.raises(ParamError, match="is too large a picture"):
        Images(path=tmp_path).check()


@pytest.mark.parametrize("chunk", [b"tEXt", b"IDAT", b"iCCP"])
def test_a_chunk_that_is_longer_than_the_file_is_not_decoded(chunk: bytes, tmp_path: Path) -> None:
    good = png(8, 8)
    at = good.index(b"IDAT") - 4
    (tmp_path / "1.png").write_bytes(good[:at] + struct.pack(">I", 0x7FFFFFFF) + chunk + good[at:])
    with pytest.raises(ValueError, match=r"1\.png' is truncated or damaged"):
        read_picture(tmp_path / "1.png")


@pytest.mark.parametrize("side", [40_000, 100_000])
def test_a_picture_of_impossible_size_is_no_video(side: int, tmp_path: Path) -> None:
    (tmp_path / "1.png").write_bytes(png(side, side))
    with pytest.raises(ParamError, match=r"too large pictures|is not a complete video that OpenCV can read"):
        Video(path=tmp_path / "1.png").check()


@pytest.mark.parametrize("number", ["99999", "99999999999999999999", "9" * 200])
def test_a_camera_of_any_number_is_refused_in_words(number: str) -> None:
    with pytest.raises(ParamError, match=f"there is no camera {number}"):
        open_capture(Path(number))


def test_a_stream_is_waited_for_as_long_as_is_asked() -> None:
    with pytest.raises(ParamError, match="cannot be opened"):
        open_capture(Path("http://192.0.2.1:9/none.mp4"), 0.01)  # RFC 5737: no host has this address


def test_errors_of_interruptible_calls_are_those_of_the_call() -> None:
    assert interruptible(lambda: 3) == 3
    with pytest.raises(ZeroDivisionError):
        interruptible(lambda: 1 / 0)


def test_pictures_are_not_enlarged_beyond_what_a_camera_has(tmp_path: Path) -> None:
    (tmp_path / "1.pgm").write_bytes(b"P5 1000 1000 255\n" + bytes(10**6))
    with pytest.raises(ParamError, match="64 million pixels"):
        Images(path=tmp_path, scale=16.0).check()
    with pytest.raises(ExceptionGroup) as raised:
        Images(path=tmp_path, size=(16384, 16384)).check()
    assert "64 million pixels" in str(raised.value.exceptions)
