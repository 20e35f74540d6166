"""Byte offsets of the stamp and the sequence number of an LCM type."""

from __future__ import annotations

from graphnav.core.codec import fields_of

_STAMP_AT = 8
_SEQ_AT = 16
_STAMPS = ("utime", "timestamp")


def offsets_of(lcm_class: type) -> tuple[int | None, int | None]:
    """Return the byte offsets of stamp and sequence number in a message of an lcm-gen class, None where it has none.

    A stamp is a first field ``int64_t utime`` or ``timestamp``, in microseconds by LCM convention; a sequence number is
    ``int64_t seq`` directly after it. Both follow the 8 bytes of the fingerprint.
    """
    first, second = ([*fields_of(lcm_class), None, None])[:2]
    if first is None or first.name not in _STAMPS or first.primitive != "int64_t" or first.dims:
        return None, None
    if second is None or second.name != "seq" or second.primitive != "int64_t" or second.dims:
        return _STAMP_AT, None
    return _STAMP_AT, _SEQ_AT
