"""Encode and decode messages with their envelope: timestamp and sequence number."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any, TypeVar

from graphnav.core.codec.compiled import codec_of
from graphnav.core.codec.errors import DecodeError
from graphnav.core.codec.flat_decode import MessageDecoder, is_flat, message_decoder, sizes_of
from graphnav.core.codec.flat_encode import FinitenessCheck, MessageEncoder, finiteness_check, message_encoder
from graphnav.core.codec.layout import fields_of, fingerprint
from graphnav.core.messages import Message

M = TypeVar("M", bound=Message)

_ENVELOPE = frozenset({"utime", "seq"})


def encode(message: Message, utime: int, seq: int) -> bytes:
    """Return a message's bytes, stamped ``utime`` (microseconds) and numbered ``seq``; raises EncodeError."""
    message_class: type = type(message)
    data = _encoder_of(message_class)(message, utime, seq)
    if data is not None:
        return data
    return codec_of(message.lcm_class).encode({**message.lcm_fields(), "utime": utime, "seq": seq})


def not_finite(message: Message) -> str | None:
    """Return what the message's own ``not_finite`` returns; quicker where all is well."""
    message_class: type = type(message)
    return None if _check_of(message_class)(message) else message.not_finite()


def decode(message_class: type[M], data: bytes) -> tuple[int, int, M]:
    """Return ``(utime, seq, message)``; raises DecodeError for anything that is not such a message.

    A message of one of the class's former types is one.
    """
    cached: type = message_class
    decoded: tuple[int, int, M] | None = _decoder_of(cached)(data)
    if decoded is not None:
        return decoded
    values = codec_of(_type_of(message_class, data)).decode(data)
    try:
        message = message_class.from_lcm_fields(values)
        return values["utime"], values["seq"], message
    except (KeyError, TypeError, ValueError) as error:
        raise DecodeError(f"not of type {message_class.__name__}: {error}") from error


@functools.cache
def _encoder_of(message_class: type[Message]) -> MessageEncoder:
    """Return the generated encoder of a class; one that always returns None if its fields are not simply the type's."""
    fields = fields_of(message_class.lcm_class)
    named = {field.name for field in fields} - sizes_of(fields)
    is_plain = message_class.lcm_fields is Message.lcm_fields
    if not is_plain or not is_flat(fields) or {*_names(message_class), *_ENVELOPE} != named:
        return _unable
    return message_encoder(fields, fingerprint(message_class.lcm_class))


@functools.cache
def _check_of(message_class: type[Message]) -> FinitenessCheck:
    """Return the generated check of a class; one that always returns None if its fields are not the type's."""
    fields = fields_of(message_class.lcm_class)
    is_plain = message_class.not_finite is Message.not_finite
    if not is_plain or not {field.name for field in fields}.issuperset(_names(message_class)):
        return _unable
    may_be_infinite = {f.name for f in dataclasses.fields(message_class) if not f.metadata.get("finite", True)}
    return finiteness_check(fields, set(_names(message_class)) - may_be_infinite)


@functools.cache
def _decoder_of(message_class: type[Message]) -> MessageDecoder:
    """Return the generated decoder of a class; one that always returns None if it is more than its fields."""
    fields = fields_of(message_class.lcm_class)
    names = {field.name for field in fields}
    is_plain = message_class.is_plain and _function(message_class.from_lcm_fields) is _function(Message.from_lcm_fields)
    if not is_plain or not is_flat(fields) or not names.issuperset({*_names(message_class), *_ENVELOPE}):
        return _unable
    return message_decoder(fields, fingerprint(message_class.lcm_class), message_class, _names(message_class))


def _type_of(message_class: type[Message], data: bytes) -> type:
    """Return the former type of a message class that the bytes begin with, else its type."""
    former = (one for one in message_class.former_lcm_classes if data[:8] == fingerprint(one))
    return next(former, message_class.lcm_class)


def _names(message_class: type[Message]) -> tuple[str, ...]:
    return tuple(field.name for field in dataclasses.fields(message_class))


def _unable(*_: Any) -> None:
    return None


def _function(method: Any) -> Any:
    """Return the function of a class method."""
    return method.__func__
