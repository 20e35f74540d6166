"""LCM bytes and numpy arrays: what lcm-gen's Python does, fast."""

from graphnav.codec.compiled import Codec, codec_of
from graphnav.codec.definition import lcm_text_of
from graphnav.codec.envelope import decode, encode
from graphnav.codec.errors import DecodeError, EncodeError
from graphnav.codec.known import add_type, message_class_of, message_types, type_named, type_of
from graphnav.codec.layout import fields_of, fingerprint, lcm_name

__all__ = [
    "Codec",
    "DecodeError",
    "EncodeError",
    "add_type",
    "codec_of",
    "decode",
    "encode",
    "fields_of",
    "fingerprint",
    "lcm_name",
    "lcm_text_of",
    "message_class_of",
    "message_types",
    "type_named",
    "type_of",
]
