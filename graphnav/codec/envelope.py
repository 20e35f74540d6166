"""Encode and decode messages with their envelope: timestamp and sequence number."""

from __future__ import annotations

from typing import TypeVar

from graphnav.codec.compiled import codec_of
from graphnav.codec.errors import DecodeError
from graphnav.messages import Message

M = TypeVar("M", bound=Message)


def encode(message: Message, utime: int, seq: int) -> bytes:
    """Return a message's bytes, stamped ``utime`` (microseconds) and numbered ``seq``; raises EncodeError."""
    return codec_of(message.lcm_class).encode({**message.lcm_fields(), "utime": utime, "seq": seq})


def decode(message_class: type[M], data: bytes) -> tuple[int, int, M]:
    """Return ``(utime, seq, message)``; raises DecodeError for anything that is not such a message."""
    values = codec_of(message_class.lcm_class).decode(data)
    try:
        message = message_class.from_lcm_fields(values)
        return values["utime"], values["seq"], message
    except (KeyError, TypeError, ValueError) as error:
        raise DecodeError(f"not of type {message_class.__name__}: {error}") from error
