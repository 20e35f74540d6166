"""Generated functions encode and decode messages like the general codec, and leave errors to it."""

from __future__ import annotations

import dataclasses
import math
import struct
from typing import Any

import graphnav_lcm
import numpy as np
import pytest

from graphnav import CameraInfo, Flow, GuardState, LocalMap, Motion, Plane, Scan, Stop, Twist
from graphnav.core.codec import Codec, DecodeError, EncodeError, codec_of, decode, encode, message_classes, not_finite
from graphnav.core.codec.layout import PRIMITIVES, Field, fields_of
from graphnav.core.messages import Message

UTIME, SEQ = 1_234_567, 89
PLAIN = [
    found
    for found in message_classes()
    if found.__module__.startswith("graphnav.") and all(f.struct is None for f in fields_of(found.lcm_class))
]
STRINGS = ("", "a", "Größe", "line\nbreak")


def value_of(field: Field, shape: tuple[int, ...], rng: np.random.Generator) -> Any:
    """Return a value of a field's type."""
    if field.primitive == "string":
        strings = tuple(rng.choice(STRINGS, shape or 1).tolist())
        return strings if field.dims else strings[0]
    dtype = np.dtype(PRIMITIVES[field.primitive].replace("q", "i8"))
    values = rng.uniform(0, 100, shape).astype(dtype)
    return values if field.dims else values.item()


def message_of(message_class: type[Message], seed: int) -> Message:
    """Return a message with arrays of 0 to 3 elements an axis."""
    rng = np.random.default_rng(seed)
    fields = {field.name: field for field in fields_of(message_class.lcm_class)}
    sizes = {dim: int(rng.integers(4)) for field in fields.values() for dim in field.dims if isinstance(dim, str)}
    if message_class.__name__ == "Image":
        return message_class(pixels=rng.integers(0, 256, (2, 3), np.uint8), step_px=4)  # type: ignore[call-arg]
    if message_class is LocalMap:
        state = rng.integers(0, 4, (2, 3), np.uint8)
        return LocalMap(0.1, -0.1, -0.1, 0.0, 0.0, float(rng.uniform(-3, 3)), state)
    if message_class is CameraInfo:
        matrix, more = rng.uniform(1, 9, (3, 3)), rng.uniform(1, 9, (3, 4))
        return CameraInfo(3, 4, "plumb_bob", matrix, rng.uniform(0, 1, 5 * (seed % 2)), matrix.T.copy(), more)
    if message_class is Scan:
        return Scan(-0.1, 0.1, 0.0, 9.0, rng.uniform(0, 9, 1 + seed % 3).astype(np.float32))
    values = {}
    for name in (field.name for field in dataclasses.fields(message_class)):
        shape = tuple(dim if isinstance(dim, int) else sizes[dim] for dim in fields[name].dims)
        values[name] = value_of(fields[name], shape, rng)
    if values.get("step_px") == 0:  # it is read as 1
        values["step_px"] = 1
    return message_class(**values)


def by_the_general_codec(message: Message) -> bytes:
    """Return the bytes that the codec without generated functions makes."""
    codec = Codec(message.lcm_class)
    out: list[Any] = [codec.fingerprint]
    codec.encode_into({**message.lcm_fields(), "utime": UTIME, "seq": SEQ}, out)
    return b"".join(out)


@pytest.mark.parametrize("message_class", PLAIN, ids=lambda found: found.__name__)
def test_bytes_are_those_of_the_general_codec(message_class: type[Message]) -> None:
    for seed in range(20):
        message = message_of(message_class, seed)
        assert encode(message, UTIME, SEQ) == by_the_general_codec(message)


@pytest.mark.parametrize("message_class", PLAIN, ids=lambda found: found.__name__)
def test_decode_inverts_encode(message_class: type[Message]) -> None:
    for seed in range(20):
        message = message_of(message_class, seed)
        utime, seq, decoded = decode(message_class, encode(message, UTIME, SEQ))
        assert (utime, seq, type(decoded)) == (UTIME, SEQ, message_class)
        assert list(vars(decoded)) == list(vars(message))
        for name, value in vars(message).items():
            found = getattr(decoded, name)
            assert type(found) is type(value)
            if isinstance(value, np.ndarray):
                assert found.dtype == value.dtype
                assert not found.flags.writeable
                np.testing.assert_array_equal(found, value)
            else:
                assert found == value


@pytest.mark.parametrize("message_class", PLAIN, ids=lambda found: found.__name__)
def test_every_cut_of_a_message_is_refused(message_class: type[Message]) -> None:
    data = encode(message_of(message_class, 3), UTIME, SEQ)
    for end in range(len(data)):
        with pytest.raises(DecodeError):
            decode(message_class, data[:end])
    with pytest.raises(DecodeError, match="its fields end at"):
        decode(message_class, data + b"\0")


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf, 3e38, 1.0])
def test_the_generated_check_agrees_with_the_message(number: float) -> None:
    values = np.full((2, 2), number, np.float32)
    for message in (
        Flow(uv_px=np.stack([values, values], 2), valid=np.ones((2, 2), np.uint8), interval_us=1),
        Flow(uv_px=np.stack([values, values]).transpose(1, 2, 0), valid=np.ones((2, 2), np.uint8), interval_us=1),
        Twist(v_mps=0.0, omega_radps=number),
    ):
        assert not_finite(message) == message.not_finite()
        assert (not_finite(message) is None) == math.isfinite(number)


def guard_state(**changes: Any) -> GuardState:
    """Return a guard's decision for one cause."""
    one = np.ones(1)
    fields: dict[str, Any] = {"causes": ("stale",), "ports": ("plane",), "values": one, "limits": one} | changes
    return GuardState(may_move=False, may_advance=False, overridden=False, stopped=False, **fields)


def test_lists_of_strings_are_taken_like_tuples() -> None:
    assert encode(guard_state(causes=["stale"]), 0, 0) == encode(guard_state(), 0, 0)


@pytest.mark.parametrize(
    ("message", "text"),
    [
        (guard_state(causes=("stale", "blind")), r"expected shape"),
        (guard_state(causes=(7,)), r"causes: expected str, found 7"),
        (guard_state(causes=("\ud800",)), r"causes: expected str"),
        (guard_state(values=np.ones(1, np.complex64)), r"values: expected float64, found complex64"),
        (Stop(engaged=True, reason=None), r"reason: expected str, found None"),  # type: ignore[arg-type]
        (Twist(v_mps="fast", omega_radps=0.0), r"v_mps: .* \(found 'fast'\)"),  # type: ignore[arg-type]
        (Motion(0.0, 0.0, 0.0, interval_us=0.5), r"interval_us: .* \(found 0.5\)"),  # type: ignore[arg-type]
    ],
)
def test_what_does_not_fit_is_named(message: Message, text: str) -> None:
    with pytest.raises(EncodeError, match=text):
        encode(message, 0, 0)


@pytest.mark.parametrize("n_causes", [-1, 2, 2**31 - 1])
def test_a_wrong_number_of_strings_is_refused(n_causes: int) -> None:
    data = bytearray(encode(guard_state(), 0, 0))
    struct.pack_into(">i", data, 28, n_causes)
    with pytest.raises(DecodeError, match="guard_state_t"):
        decode(GuardState, bytes(data))


def test_arrays_of_one_type_are_independent_of_each_other() -> None:
    cells = np.arange(6, dtype=np.float32).reshape(2, 3)
    plane = Plane(np.ones((2, 3), np.uint8), cells, np.zeros((2, 3), np.uint8), 4, 0.5)
    decoded = decode(Plane, encode(plane, 0, 0))[2]
    assert decoded.obstacle.all()
    assert not decoded.valid.any()
    assert (decoded.score == cells).all()


class Checked(Message, lcm=graphnav_lcm.twist_t):
    """A command that refuses to be made with a negative speed."""

    v_mps: float
    omega_radps: float

    def __post_init__(self) -> None:
        if self.v_mps < 0:
            raise ValueError("backwards")


class Reversed(Message, lcm=graphnav_lcm.twist_t):
    """A command that stores the opposite turning rate."""

    v_mps: float
    turn_radps: float

    def lcm_fields(self) -> dict[str, Any]:
        return {"v_mps": self.v_mps, "omega_radps": -self.turn_radps}

    @classmethod
    def from_lcm_fields(cls, values: Any) -> Reversed:
        return cls(values["v_mps"], -values["omega_radps"])


class Part(Message, lcm=graphnav_lcm.twist_t):
    """A command that lacks a field of its type."""

    v_mps: float


def test_a_constructor_that_checks_is_called() -> None:
    assert decode(Checked, encode(Checked(1.0, 0.0), 0, 0))[2].v_mps == 1
    with pytest.raises(DecodeError, match="not of type Checked: backwards"):
        decode(Checked, encode(Twist(-1.0, 0.0), 0, 0))


def test_a_conversion_of_fields_is_called() -> None:
    data = encode(Reversed(1.0, 2.0), 0, 0)
    assert decode(Twist, data)[2].omega_radps == -2
    assert decode(Reversed, data)[2].turn_radps == 2


def test_a_message_without_a_field_of_its_type_is_read_and_not_written() -> None:
    assert decode(Part, encode(Twist(1.0, 2.0), 0, 0))[2].v_mps == 1
    with pytest.raises(EncodeError, match="omega_radps is missing"):
        encode(Part(1.0), 0, 0)


def test_strings_are_those_of_lcm_gen() -> None:
    made = graphnav_lcm.stop_t()
    made.utime, made.seq, made.engaged, made.reason = UTIME, SEQ, True, "Größe"
    message = Stop(engaged=True, reason="Größe")
    assert encode(message, UTIME, SEQ) == made.encode()
    values = codec_of(graphnav_lcm.stop_t).decode(made.encode())
    assert (values["reason"], values["engaged"]) == ("Größe", True)
