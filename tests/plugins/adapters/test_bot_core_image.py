"""``bot_core.image_t``: every pixel format to `Image`, `Image` back, and messages that hold no picture."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from graphnav_adapters import graphnav_adapters
from graphnav_adapters.bot_core_image import BGR, GRAY, MJPEG, RGB, BotCoreImage
from hypothesis import given
from hypothesis import strategies as st

from graphnav import Adapter, Image
from graphnav.core.codec import codec_of, fingerprint

ADAPTER = BotCoreImage()
CODEC = codec_of(BotCoreImage.lcm_class)
FINGERPRINT = "14739ffe13d5f5f0"
"""Of libbot's definition: names, types and sizes of the fields; what lcm-gen 1.5.3 makes of the struct below."""

GRAY_PIXELS = np.arange(4 * 6, dtype=np.uint8).reshape(4, 6)
RGB_PIXELS = np.random.default_rng(3).integers(0, 256, (4, 6, 3), dtype=np.uint8)


def fields(pixels: np.ndarray[Any, Any], pixelformat: int, **changed: Any) -> dict[str, Any]:
    """Return the fields of a picture without padding."""
    rows, cols = pixels.shape[:2]
    return {
        "utime": 5,
        "width": cols,
        "height": rows,
        "row_stride": pixels[0].size,
        "pixelformat": pixelformat,
        "data": pixels.reshape(-1),
        "metadata": (),
    } | changed


def jpeg(pixels: np.ndarray[Any, Any]) -> bytes:
    return cv2.imencode(".jpg", pixels)[1].tobytes()


def mjpeg(data: bytes, cols: int = 64, rows: int = 48, **changed: Any) -> dict[str, Any]:
    return fields(np.zeros((rows, cols), np.uint8), MJPEG, data=np.frombuffer(data, np.uint8), **changed)


def smooth() -> np.ndarray[Any, Any]:
    """Return a picture, blue-green-red, that JPEG keeps almost as it is."""
    rows, cols = np.mgrid[:48, :64]
    return np.stack([rows * 2, cols * 3, 255 - rows], axis=2).astype(np.uint8)


def crossed(values: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return fields as they come out of a received message."""
    return CODEC.decode(CODEC.encode(values))


def test_the_hook_gives_it() -> None:
    adapter = graphnav_adapters()[0]
    assert isinstance(adapter, BotCoreImage)
    assert isinstance(adapter, Adapter)
    assert (adapter.type_name, adapter.message) == ("bot_core.image_t", Image)
    assert adapter.reads()
    assert adapter.writes()


def test_the_type_is_libbots(tmp_path: Path) -> None:
    (tmp_path / "meta.lcm").write_text(
        "package bot_core; struct image_metadata_t { string key; int32_t n; byte value[n]; }"
    )
    (tmp_path / "image.lcm").write_text(
        "package bot_core; struct image_t { int64_t utime; int32_t width; int32_t height; int32_t row_stride;"
        "int32_t pixelformat; int32_t size; byte data[size]; int32_t nmetadata; image_metadata_t metadata[nmetadata]; }"
    )
    lcm_gen = Path(sys.executable).parent / "lcm-gen"
    files = [str(tmp_path / name) for name in ("meta.lcm", "image.lcm")]
    subprocess.run([str(lcm_gen), "-p", "--ppath", str(tmp_path), *files], check=True)
    code = (
        "import bot_core as b; p = b.image_t(); p.size, p.data = 2, b'ab'; m = b.image_metadata_t(); "
        "m.key, m.n, m.value = 'k', 1, b'v'; p.nmetadata, p.metadata = 1, [m]; print(p.encode().hex())"
    )
    theirs = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, check=True, capture_output=True, text=True
    ).stdout
    assert theirs[:16] == fingerprint(BotCoreImage.lcm_class).hex() == FINGERPRINT
    values = CODEC.decode(bytes.fromhex(theirs))
    assert values["data"].tobytes() == b"ab"
    assert values["metadata"][0]["key"] == "k"
    assert CODEC.encode(values).hex() == theirs.strip()


@pytest.mark.parametrize("pixels", [GRAY_PIXELS, RGB_PIXELS], ids=["gray", "rgb"])
def test_an_image_crosses_and_comes_back(pixels: np.ndarray[Any, Any]) -> None:
    values = crossed(ADAPTER.to_lcm(Image(pixels=pixels), 1_700_000_000_000_001))
    assert ADAPTER.utime(values) == 1_700_000_000_000_001
    assert values["size"] == pixels.size == values["row_stride"] * values["height"]
    assert np.array_equal(ADAPTER.from_lcm(values).pixels, pixels)


def test_blue_green_red_becomes_red_green_blue() -> None:
    image = ADAPTER.from_lcm(crossed(fields(np.ascontiguousarray(RGB_PIXELS[:, :, ::-1]), BGR)))
    assert np.array_equal(image.pixels, RGB_PIXELS)


@pytest.mark.parametrize("unpadded_end", [False, True])
@pytest.mark.parametrize(("pixels", "pixelformat"), [(GRAY_PIXELS, GRAY), (RGB_PIXELS, RGB)], ids=["gray", "rgb"])
def test_padding_of_rows_is_left_out(pixels: np.ndarray[Any, Any], pixelformat: int, unpadded_end: bool) -> None:
    padded = np.full((4, pixels[0].size + 7), 255, np.uint8)
    padded[:, :-7] = pixels.reshape(4, -1)
    data = padded.reshape(-1)[: -7 if unpadded_end else None]
    values = crossed(fields(pixels, pixelformat, data=data, row_stride=padded.shape[1]))
    assert np.array_equal(ADAPTER.from_lcm(values).pixels, pixels)


def test_a_colour_jpeg_is_red_green_blue() -> None:
    image = ADAPTER.from_lcm(crossed(mjpeg(jpeg(smooth()))))
    assert image.pixels.shape == (48, 64, 3)
    assert np.abs(image.pixels[:, :, ::-1].astype(int) - smooth()).mean() < 3


def test_a_gray_jpeg_is_gray() -> None:
    gray = smooth()[:, :, 1]
    image = ADAPTER.from_lcm(crossed(mjpeg(jpeg(gray))))
    assert image.pixels.shape == (48, 64)
    assert np.abs(image.pixels.astype(int) - gray).mean() < 2


def test_a_jpeg_without_huffman_tables_as_webcams_send_them() -> None:
    complete = jpeg(smooth())
    stripped, at = bytearray(complete[:2]), 2
    while complete[at + 1] != 0xDA:
        end = at + 2 + int.from_bytes(complete[at + 2 : at + 4])
        stripped += b"" if complete[at + 1] == 0xC4 else complete[at:end]
        at = end
    stripped += complete[at:]
    assert len(stripped) < len(complete)
    assert np.array_equal(ADAPTER.from_lcm(mjpeg(bytes(stripped))).pixels, ADAPTER.from_lcm(mjpeg(complete)).pixels)


def test_padding_after_a_jpeg_does_no_harm() -> None:
    complete = jpeg(smooth())
    assert np.array_equal(
        ADAPTER.from_lcm(mjpeg(complete + bytes(500))).pixels, ADAPTER.from_lcm(mjpeg(complete)).pixels
    )


def test_the_orientation_that_a_jpeg_asks_for_does_not_turn_it() -> None:
    exif = b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0"
    complete = jpeg(smooth())
    turned = complete[:2] + b"\xff\xe1" + (len(exif) + 2).to_bytes(2) + exif + complete[2:]
    assert ADAPTER.from_lcm(mjpeg(turned)).pixels.shape == (48, 64, 3)


def with_size(data: bytes, rows: int, cols: int) -> bytes:
    """Return a JPEG whose header says another size."""
    at = data.index(b"\xff\xc0") + 5
    return data[:at] + rows.to_bytes(2) + cols.to_bytes(2) + data[at + 4 :]


COMPLETE = jpeg(smooth())
BAD: dict[str, tuple[dict[str, Any], str]] = {
    "too few bytes": (
        fields(GRAY_PIXELS, GRAY, data=GRAY_PIXELS.reshape(-1)[:-1]),
        "size is 23, expected height . row_stride = 4 . 6 = 24",
    ),
    "too many bytes": (fields(GRAY_PIXELS, GRAY, data=np.zeros(25, np.uint8)), "size is 25, expected"),
    "no bytes": (fields(GRAY_PIXELS, GRAY, data=np.zeros(0, np.uint8)), "size is 0, expected"),
    "small stride": (
        fields(GRAY_PIXELS, GRAY, row_stride=5),
        "row_stride is 5, expected 6 or more, the bytes of a row",
    ),
    "no stride": (fields(GRAY_PIXELS, GRAY, row_stride=0), "row_stride is 0"),
    "negative stride": (fields(GRAY_PIXELS, GRAY, row_stride=-6), "row_stride is -6"),
    "gray as colour": (fields(GRAY_PIXELS, RGB), "row_stride is 6, expected 18 or more"),
    "negative height": (fields(GRAY_PIXELS, GRAY, height=-4), "height is -4, expected 1 or more"),
    "no width": (fields(GRAY_PIXELS, GRAY, width=0), "width is 0, expected 1 or more"),
    "absurd size": (fields(GRAY_PIXELS, GRAY, width=2**31 - 1, height=2**31 - 1), "expected 64 million at most"),
    "absurd JPEG": (mjpeg(COMPLETE, width=60_000, height=60_000), "expected 64 million at most"),
    "other format": (
        fields(GRAY_PIXELS, 1448695129),
        r"pixelformat is 1448695129 \(YUYV\), expected 1497715271 \(GREY\), 8",
    ),
    "no format": (fields(GRAY_PIXELS, -2), "pixelformat is -2, expected"),
    "not a JPEG": (mjpeg(b"RIFF" + bytes(100)), "not a JPEG"),
    "empty JPEG": (mjpeg(b""), "not a JPEG"),
    "two bytes": (mjpeg(COMPLETE[:2]), "truncated"),
    "half a header": (mjpeg(COMPLETE[:100]), "truncated"),
    "no segment": (mjpeg(COMPLETE[:2] + b"\xff\xe0\0\0" + COMPLETE[2:]), "damaged header"),
    "short frame header": (mjpeg(COMPLETE[:2] + b"\xff\xc0\0\x04\0\0" + COMPLETE[2:]), "damaged header"),
    "no marker": (mjpeg(COMPLETE[:2] + b"abcd" + COMPLETE[2:]), "damaged header"),
    "a scan without a frame": (mjpeg(COMPLETE[:2] + COMPLETE[COMPLETE.index(b"\xff\xda") :]), "JPEG"),
    "half a JPEG": (mjpeg(COMPLETE[: len(COMPLETE) // 2]), "truncated"),
    "all but the end": (mjpeg(COMPLETE[:-2]), "truncated"),
    "another size": (mjpeg(COMPLETE, cols=32, rows=24), "width x height is 32x24, expected 64x48, which its JPEG has"),
    "a bomb": (
        mjpeg(with_size(COMPLETE, 65_000, 65_000)),
        r"the JPEG's width \* height is 65000 \* 65000, expected 64 million",
    ),
    "no rows": (mjpeg(with_size(COMPLETE, 0, 64)), "the JPEG's height is 0, expected 1 or more"),
    "only a header": (mjpeg(COMPLETE[: COMPLETE.index(b"\xff\xda")] + b"\xff\xda\0\x02\xff\xd9"), "cannot be decoded"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_holds_no_picture_says_why(name: str) -> None:
    values, reason = BAD[name]
    with pytest.raises(ValueError, match=reason):
        ADAPTER.from_lcm(crossed(values))


def test_a_jpeg_of_four_channels_is_refused() -> None:
    at = COMPLETE.index(b"\xff\xc0") + 9
    with pytest.raises(ValueError, match="number of channels is 4, expected 1"):
        ADAPTER.from_lcm(mjpeg(COMPLETE[:at] + b"\x04" + COMPLETE[at + 1 :]))


@pytest.mark.parametrize("shape", [(4,), (4, 6, 2), (4, 6, 4), (4, 6, 3, 1)])
def test_an_image_of_other_channels_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="neither"):
        ADAPTER.to_lcm(Image(pixels=np.zeros(shape, np.uint8)), 0)


INT32 = st.one_of(st.integers(-2, 10), st.integers(-(2**31), 2**31 - 1))
FORMATS = st.one_of(st.sampled_from([GRAY, RGB, BGR, MJPEG]), INT32)


@st.composite
def jpegs(draw: st.DrawFn) -> bytes:
    """Draw a JPEG with bytes of its header changed, cut off, or put in."""
    data = bytearray(COMPLETE)
    for place, value in draw(st.lists(st.tuples(st.integers(0, 640), st.integers(0, 255)), max_size=4)):
        data[place] = value
    return bytes(data[: draw(st.integers(0, len(data)))])


@given(
    width=INT32,
    height=INT32,
    row_stride=INT32,
    pixelformat=FORMATS,
    data=st.one_of(st.binary(max_size=200), jpegs()),
)
def test_any_message_gives_a_picture_or_a_value_error(data: bytes, **values: int) -> None:
    message = crossed({"utime": 0, "data": data, "metadata": (), **values})
    try:
        image = ADAPTER.from_lcm(message)
    except ValueError:
        return
    assert image.pixels.shape[:2] == (values["height"], values["width"])
    assert image.pixels.dtype == np.uint8


@given(data=jpegs())
def test_any_jpeg_gives_a_picture_or_a_value_error(data: bytes) -> None:
    try:
        image = ADAPTER.from_lcm(mjpeg(data))
    except ValueError:
        return
    assert image.pixels.shape[:2] == (48, 64)
