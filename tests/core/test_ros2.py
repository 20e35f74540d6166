"""ROS 2 types by their definitions, their messages as bytes, and topics' names."""

from __future__ import annotations

import random
import struct
from contextlib import suppress

import numpy as np
import pytest

from graphnav.core.codec import DecodeError, EncodeError
from graphnav.core.errors import DeclarationError, UserError
from graphnav.core.ros2 import DOMAIN, Ros2Network, RosType, why_not_a_topic

IMAGE = RosType(
    "sensor_msgs/msg/Image",
    "# a picture\nstd_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n"
    "uint32 step  # bytes\nuint8 MONO=1\nuint8[] data\n",
)
MIXED = RosType(
    "test/Mixed",
    "bool[] flags\nfloat64 x\nint16[3] three\nstring<=8[] words\nInner[] inner\nuint64 last\n"
    "===\nMSG: test/Inner\nuint8 a\nfloat32 b\n",
)
HEADER = {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "cam"}


def test_a_message_comes_back_as_it_was() -> None:
    fields = {
        "flags": np.array([True, False]),
        "x": 0.5,
        "three": np.array([1, -2, 3]),
        "words": ["a", "bc", ""],
        "inner": [{"a": 1, "b": 0.25}, {"a": 255, "b": -1.0}],
        "last": 2**63,
    }
    found = MIXED.decode(MIXED.encode(fields))
    assert found["flags"].tolist() == [True, False]
    assert found["three"].tolist() == [1, -2, 3]
    assert {name: found[name] for name in ("x", "words", "inner", "last")} == {
        name: fields[name] for name in ("x", "words", "inner", "last")
    }


def test_the_bytes_are_those_of_the_standard() -> None:
    data = IMAGE.encode({"header": HEADER, "height": 2, "width": 1, "encoding": "mono8", "step": 1, "data": [7, 8]})
    by_hand = struct.pack("<4siII4sIII6sB", b"\0\1\0\0", 1, 2, 4, b"cam\0", 2, 1, 6, b"mono8\0", 0)
    by_hand += bytes(-(len(by_hand) - 4) % 4) + struct.pack("<II2B", 1, 2, 7, 8)
    assert data == by_hand
    big = RosType("test/Two", "uint8 a\nuint32 b").decode(b"\0\0\0\0" + struct.pack(">B3xI", 1, 258))
    assert big == {"a": 1, "b": 258}
    wide = RosType("test/Wide", "uint32 a\nfloat64 b")
    assert wide.decode(b"\0\7\0\0" + struct.pack("<Id", 3, 0.5)) == {"a": 3, "b": 0.5}  # CDR 2 aligns to 4 bytes


def test_arrays_are_not_copied_and_cannot_be_changed() -> None:
    data = IMAGE.encode({"data": np.arange(100, dtype=np.uint8)})
    found = IMAGE.decode(data)["data"]
    assert np.shares_memory(found, np.frombuffer(data, np.uint8))
    assert not found.flags.writeable


@pytest.mark.parametrize("kind", [IMAGE, MIXED])
def test_spoiled_bytes_decode_or_raise_decode_error(kind: RosType) -> None:
    source = random.Random(3)
    good = kind.encode({"inner": [{}] * 3} if kind is MIXED else {"header": HEADER, "data": [1] * 50})
    for _ in range(500):
        data = bytearray(good[: source.randrange(len(good) + 1)])
        for _ in range(min(3, len(data))):
            data[source.randrange(len(data))] = source.randrange(256)
        with suppress(DecodeError):
            kind.decode(bytes(data))


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"", "the bytes begin with nothing, expected 00 01 00 00: CDR"),
        (b"\0\1\0\0\1", "5 bytes end within a test/Two"),
        (b"\0\1\0\0" + bytes(16), "8 of 20 bytes are left after the last field of a test/Two"),
        (bytes(2**26 + 1), "67108865 bytes, expected at most 67108864"),
    ],
)
def test_what_is_wrong_with_bytes_is_told(data: bytes, told: str) -> None:
    with pytest.raises(DecodeError) as caught:
        RosType("test/Two", "uint8 a\nuint32 b").decode(data)
    assert str(caught.value) == told


@pytest.mark.parametrize(
    ("fields", "told"),
    [
        ({"colour": 1}, "sensor_msgs/msg/Image has no field 'colour': it has header, height, width"),
        ({"height": -1}, "height is -1, expected uint32"),
        ({"height": 0.5}, "height is 0.5, expected uint32"),
        ({"data": ["a"]}, "data is ['a'], expected uint8"),
        ({"header": 1}, "header is 1, expected the fields of std_msgs/Header"),
    ],
)
def test_what_is_wrong_with_fields_is_told(fields: dict[str, object], told: str) -> None:
    with pytest.raises(EncodeError) as caught:
        IMAGE.encode(fields)
    assert str(caught.value).startswith(told)


@pytest.mark.parametrize(
    ("definition", "told"),
    [
        ("uint8", "has the line 'uint8', expected: type name"),
        ("wstring text", "has a wstring, which is not supported"),
        ("other/Type x", "uses 'other/Type' without its definition: append '===', a line 'MSG: other/Type'"),
        ("Loop x\n===\nMSG: test/Loop\nLoop x", "the ROS type 'test/Loop' contains itself"),
    ],
)
def test_what_is_wrong_with_a_definition_is_told(definition: str, told: str) -> None:
    with pytest.raises(DeclarationError) as caught:
        RosType("test/Wrong", definition)
    assert told in str(caught.value)


def test_names_of_topics_and_types() -> None:
    assert IMAGE.dds_name == "sensor_msgs::msg::dds_::Image_"
    assert why_not_a_topic("/camera/image_raw") is None
    assert why_not_a_topic("cmd_vel") == ("'cmd_vel' is not a ROS topic", "write /cmd_vel")
    for name in ("", "/", "/a b", "/1", "/a/", "~/x", "/a__b"):
        assert why_not_a_topic(name) is not None, name


def test_the_domain_is_the_graphs_or_that_of_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(DOMAIN, "7")
    assert Ros2Network().resolved() == Ros2Network(7)
    assert Ros2Network(3).resolved() == Ros2Network(3)
    monkeypatch.setenv(DOMAIN, "233")
    with pytest.raises(UserError, match="ROS_DOMAIN_ID is '233', expected a number from 0 to 232"):
        Ros2Network().resolved()
