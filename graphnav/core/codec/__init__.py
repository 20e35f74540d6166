"""Fast encoding and decoding of LCM types with numpy arrays."""

from graphnav.core.codec.compiled import Codec, codec_of
from graphnav.core.codec.definition import comments_of, constants_of, definition_of, lcm_text_of
from graphnav.core.codec.envelope import decode, encode, not_finite
from graphnav.core.codec.errors import DecodeError, EncodeError
from graphnav.core.codec.given_types import add_given_types
from graphnav.core.codec.known_types import (
    SHIPPED,
    add_type,
    find_type,
    known_types,
    message_class_of,
    message_classes,
    message_types,
    messages_by_name,
    type_named,
    type_of,
)
from graphnav.core.codec.layout import Dim, Field, fields_of, fingerprint, lcm_name
from graphnav.core.codec.message_fields import check_fields

__all__ = [
    "SHIPPED",
    "Codec",
    "DecodeError",
    "Dim",
    "EncodeError",
    "Field",
    "add_given_types",
    "add_type",
    "check_fields",
    "codec_of",
    "comments_of",
    "constants_of",
    "decode",
    "definition_of",
    "encode",
    "fields_of",
    "find_type",
    "fingerprint",
    "known_types",
    "lcm_name",
    "lcm_text_of",
    "message_class_of",
    "message_classes",
    "message_types",
    "messages_by_name",
    "not_finite",
    "type_named",
    "type_of",
]
