"""Parse a rate or a channel's name given as an option; format ``1 message``."""

from __future__ import annotations

import argparse

MAX_FACTOR = 1e6
"""The maximum of rates, speeds and factors that options take; the inverse is the minimum."""


def positive(text: str) -> float:
    """Parse a rate or a factor: a number above 0, within `MAX_FACTOR` and its inverse."""
    try:
        if 1 / MAX_FACTOR <= (value := float(text)) <= MAX_FACTOR:
            return value
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not a number above 0, from {1 / MAX_FACTOR:g} to {MAX_FACTOR:g}")


def channel_name(text: str) -> str:
    """Parse the name of a channel: accepted by LCM and not reserved."""
    from graphnav.core.graph.wiring.channels import MAX_NAME, RESERVED

    if not text or not text.isascii() or not text.isprintable() or " " in text:
        raise argparse.ArgumentTypeError(
            f"{text!r} cannot be the name of a channel: use ASCII characters without spaces"
        )
    if len(text) > MAX_NAME:
        raise argparse.ArgumentTypeError(f"'{text}' has {len(text)} characters, but LCM takes at most {MAX_NAME}")
    if text.startswith(RESERVED):
        raise argparse.ArgumentTypeError(f"channel names that begin with '{RESERVED}' are reserved: '{text}'")
    return text


def counted(number: int, noun: str) -> str:
    """Return ``1 message`` or ``2,000 messages``."""
    return f"{number:,} {noun}" if number == 1 else f"{number:,} {noun}s"
