"""Parse a rate, a port or a channel's name given as an option; format ``1 message``."""

from __future__ import annotations

import argparse

MAX_FACTOR = 1e6
"""The maximum of rates, speeds and factors that options take; the inverse is the minimum."""
_MAX_PORT_DIGITS = 5


def positive(text: str) -> float:
    """Parse a rate or a factor: a number above 0, within `MAX_FACTOR` and its inverse."""
    try:
        if 1 / MAX_FACTOR <= (value := float(text)) <= MAX_FACTOR:
            return value
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not a number above 0, from {1 / MAX_FACTOR:g} to {MAX_FACTOR:g}")


def port_number(text: str) -> int:
    """Parse a TCP port."""
    if text.isdecimal() and text.isascii() and len(text) <= _MAX_PORT_DIGITS and int(text) < 65536:
        return int(text)
    raise argparse.ArgumentTypeError(f"'{text}' is not a port: write a number from 0 to 65535")


def channel_name(text: str) -> str:
    """Parse the name of a channel: accepted by LCM and not reserved."""
    from graphnav.core.graph.wiring.channels import why_not_a_name

    if reason := why_not_a_name(text):
        raise argparse.ArgumentTypeError(": ".join(filter(None, reason)))
    return text


def counted(number: int, noun: str) -> str:
    """Return ``1 message`` or ``2,000 messages``."""
    return f"{number:,} {noun}" if number == 1 else f"{number:,} {noun}s"
