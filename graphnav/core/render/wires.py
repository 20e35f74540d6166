"""The wires of a drawing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from graphnav.core.graph import Channel
from graphnav.core.render.boxes import Box


@dataclass(frozen=True)
class Wire:
    """A channel and one of its readers, the key of a box."""

    channel: Channel
    reader: str
    port: str
    latest: bool


def wires_of(boxes: Iterable[Box]) -> list[Wire]:
    """Return every wire, in the order of the readers."""
    return [
        Wire(port.channel, box.key, port.name, port.is_sampled)
        for box in boxes
        for port in box.inputs
        if port.channel is not None
    ]
