"""Errors of encoding and decoding."""

from __future__ import annotations

from graphnav.core.errors import GraphnavError


class EncodeError(GraphnavError):
    """The fields do not fit their LCM type."""


class DecodeError(GraphnavError):
    """The bytes are not a message of the expected LCM type."""
