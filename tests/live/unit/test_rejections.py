"""A rejected message is told by the field, its value and what is allowed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import graphnav_lcm
import numpy as np
import pytest
from graphnav_adapters.bot_core_image import GRAY, MJPEG, BotCoreImage

from graphnav import Adapter, Flow, Image, Odometry, Twist
from graphnav.core.codec import codec_of, encode, lcm_name
from graphnav.core.errors import Place
from graphnav.core.graph import Channel, InputChannel
from graphnav.core.messages import Message
from graphnav.live.clock import LiveClock
from graphnav.live.inputs.intake import Intake

IMAGE = codec_of(graphnav_lcm.image_t)
BOT_CORE = codec_of(BotCoreImage.lcm_class)
FLOW_FIELDS: dict[str, Any] = {
    "uv_px": np.zeros((2, 3, 2), np.float32),
    "valid": np.ones((2, 3), np.uint8),
    "interval_us": 100_000,
}
C_CAMERA = {"utime": 5, "seq": 0, "step_px": 0, "rows": 4, "cols": 6, "channels": 1, "data": bytes(24)}
"""The picture of a C driver that sets some fields of a zeroed struct."""
DAMAGED = "a damaged graphnav_lcm.image_t"
UNKNOWN = (
    f"the fingerprint 0102030405060708 is not of an installed type, expected {IMAGE.fingerprint.hex()} of "
    "graphnav_lcm.image_t: names, types or order of the fields in the .lcm differ"
)


def intake(message: type[Message], adapter: Adapter | None = None) -> Intake:
    """Return the intake of an input ``camera.image`` on CAMERA."""
    lcm_class: type = message.lcm_class if adapter is None else adapter.lcm_class
    name = lcm_name(lcm_class) if adapter is None else adapter.type_name
    channel = Channel("camera.image", "camera.image", message)
    source = InputChannel(channel, "CAMERA", lcm_class, name, adapter, None, None, Place("graph.yaml"))
    return Intake(source, LiveClock(), needs_all=True)


def told(found: Intake, *messages: bytes) -> dict[str, str]:
    """Return the details of the rejected messages, by reason."""
    for data in messages:
        found.mailbox.put(data, found._clock.now_s())
        for _ in found.take():
            pass
    return {reason: found.monitor.detail(reason) for reason in found.monitor.rejected}


def image(**changed: Any) -> bytes:
    return IMAGE.encode({**C_CAMERA, **changed})


def bot_core(**changed: Any) -> bytes:
    fields = {"utime": 5, "width": 6, "height": 4, "row_stride": 6, "pixelformat": GRAY, "data": bytes(24)}
    return BOT_CORE.encode({**fields, "metadata": (), **changed})


def test_a_zeroed_struct_of_c_is_a_picture() -> None:
    found = intake(Image)
    found.mailbox.put(image(), 0.0)
    (received,) = found.take()
    assert isinstance(received.message, Image)
    assert (received.message.step_px, received.message.pixels.shape) == (1, (4, 6))
    assert not found.monitor.rejected


@pytest.mark.parametrize(
    ("data", "reason", "detail"),
    [
        (image(rows=0, data=b""), "unreadable", "image_t: rows is 0, expected 1 or more"),
        (image(cols=-3), "unreadable", "image_t: cols is -3, expected 1 or more"),
        (image(channels=0), "unreadable", "image_t: channels is 0, expected 1 (gray) or 3 (red-green-blue)"),
        (image(channels=4), "unreadable", "image_t: channels is 4, expected 1 (gray) or 3 (red-green-blue)"),
        (
            image(channels=3),
            "unreadable",
            "image_t: size is 24, expected rows * cols * channels = 4 * 6 * 3 = 72",
        ),
        (image(step_px=-2), "unreadable", "image_t: step_px is -2, expected 1 or more; 0 counts as 1"),
        (
            image()[:-10],
            "undecodable",
            f"{DAMAGED} of 58 bytes: data has size = 24 elements, which need 24 bytes, but 14 are left",
        ),
        (image()[:20], "undecodable", f"{DAMAGED} of 20 bytes: it ends before the end of seq"),
        (image() + b"0", "undecodable", f"{DAMAGED} of 69 bytes: its fields end at byte 68 where size = 24"),
        (
            encode(Twist(v_mps=1.0, omega_radps=0.0), 5, 0),
            "wrong type",
            "the messages are graphnav_lcm.twist_t, expected graphnav_lcm.image_t",
        ),
        (
            b"\1\2\3\4\5\6\7\x08 another struct",
            "wrong type",
            UNKNOWN,
        ),
        (b"abc", "wrong type", "3 bytes, shorter than the fingerprint of graphnav_lcm.image_t"),
    ],
)
def test_a_field_of_a_picture_is_named(data: bytes, reason: str, detail: str) -> None:
    assert told(intake(Image), data) == {reason: detail}


def test_another_size_than_the_first_is_named() -> None:
    assert told(intake(Image), image(), image(utime=6, seq=1, rows=2, cols=3, data=bytes(6))) == {
        "wrong size": "image_t: rows x cols is 2 x 3, expected 4 x 6, as in the first message"
    }
    colour = image(utime=6, seq=1, channels=3, data=bytes(72))
    assert told(intake(Image), image(), colour) == {
        "wrong size": "image_t: rows x cols x channels is 4 x 6 x 3, expected 4 x 6, as in the first message"
    }


def test_another_step_than_the_first_is_named() -> None:
    assert told(intake(Image), image(), image(utime=6, seq=1, step_px=65535)) == {
        "wrong size": "image_t: step_px is 65535, expected 1, as in the first message"
    }


@pytest.mark.parametrize(
    "damaged", [image()[:-1], encode(Twist(v_mps=1.0, omega_radps=0.0), 5, 0)], ids=["damaged", "type"]
)
def test_messages_that_cannot_be_read_are_not_lost(damaged: bytes) -> None:
    found = intake(Image)
    told(found, image(), *[damaged] * 25, image(utime=6, seq=26))
    assert (found.used, found.lost) == (2, 0)
    told(found, image(utime=7, seq=29))
    assert (found.used, found.lost) == (3, 2)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_what_is_not_finite_is_named(value: float) -> None:
    lost = Odometry(x_m=0.0, y_m=0.0, yaw_rad=value, v_mps=0.0, omega_radps=0.0)
    assert told(intake(Odometry), encode(lost, 5, 0)) == {
        "not finite": f"odometry_t: yaw_rad is {value}, expected a finite number"
    }


def test_an_element_of_a_grid_that_is_not_finite_is_named() -> None:
    uv_px = np.zeros((2, 3, 2), np.float32)
    uv_px[1, 2, 0] = np.nan
    assert told(intake(Flow), encode(Flow(**{**FLOW_FIELDS, "uv_px": uv_px}), 5, 0)) == {
        "not finite": "flow_t: uv_px[1, 2, 0] is nan, expected a finite number"
    }


def test_a_grid_without_rows_is_named_by_the_field_of_its_type() -> None:
    empty = Flow(np.zeros((0, 3, 2), np.float32), np.zeros((0, 3), np.uint8), 100_000)
    assert told(intake(Flow), encode(empty, 5, 0)) == {"unreadable": "flow_t: rows is 0, expected 1 or more"}


@pytest.mark.parametrize(
    ("changed", "detail"),
    [
        ({"row_stride": 0}, "row_stride is 0, expected 6 or more, the bytes of a row"),
        ({"data": bytes(23)}, "size is 23, expected height * row_stride = 4 * 6 = 24"),
        ({"height": 0}, "height is 0, expected 1 or more"),
        (
            {"pixelformat": 0},
            "pixelformat is 0, expected 1497715271 (GREY), 859981650 (RGB3), 861030210 (BGR3), 1196444237 (MJPG)",
        ),
        ({"pixelformat": MJPEG}, "data is not a JPEG: it begins with 00 00 00 00, expected ff d8"),
    ],
)
def test_a_field_of_an_adapters_type_is_named(changed: Mapping[str, Any], detail: str) -> None:
    found = intake(Image, BotCoreImage())
    assert told(found, bot_core(**changed)) == {"unreadable": f"image_t: {detail}"}


class _Broken(Adapter):
    """Reads commands as odometry, and raises for what it does not expect."""

    type_name = "test.twist_t"
    lcm_class = graphnav_lcm.twist_t
    message = Odometry
    stamps: ClassVar[dict[float, int]] = {1.0: 7}

    def from_lcm(self, fields: Mapping[str, Any]) -> Odometry:
        return Odometry(
            x_m={1.0: 2.0}[fields["omega_radps"]], y_m=0.0, yaw_rad=float("inf"), v_mps=0.0, omega_radps=0.0
        )

    def utime(self, fields: Mapping[str, Any]) -> int:
        return self.stamps[fields["v_mps"]]


def test_what_an_adapter_raises_or_makes_is_told() -> None:
    for v_mps, omega_radps, expected in (
        (0.0, 1.0, {"unreadable": "utime: KeyError: 0.0"}),
        (1.0, 0.0, {"unreadable": "twist_t: KeyError: 0.0"}),
        (1.0, 1.0, {"not finite": "Odometry: yaw_rad is inf, expected a finite number"}),
    ):
        data = encode(Twist(v_mps=v_mps, omega_radps=omega_radps), 5, 0)
        assert told(intake(Odometry, _Broken()), data) == expected


def test_details_are_of_the_last_message_and_only_as_recent_as_asked_for() -> None:
    found = intake(Image)
    assert told(found, image(rows=0, data=b""), image(cols=0, data=b"", seq=1, utime=6)) == {
        "unreadable": "image_t: cols is 0, expected 1 or more"
    }
    assert found.monitor.rejected == {"unreadable": 2}
    assert found.monitor.detail("unreadable", found._clock.now_s() - 60.0)
    assert not found.monitor.detail("unreadable", found._clock.now_s() + 1.0)
