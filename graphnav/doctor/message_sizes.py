"""Measure the sizes of the messages that a graph exchanges with other programs."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import NamedTuple

from graphnav.bus import Bus
from graphnav.graph import Graph, InputChannel
from graphnav.interrupts import third_party_code
from graphnav.record import Recording
from graphnav.runner import Runner

_TICKS = 3
"""The first tick has no flow, the second has all messages."""
_MAX_S = 10.0
_ASSUMED_IMAGE_BYTES = 640 * 480 * 3
_FROM_LOG = 20


class MessageSize(NamedTuple):
    """The largest message of a channel; ``assumed``: the assumption made if the size is not known in advance."""

    channel: str
    n_bytes: int
    assumed: str = ""


@dataclass
class _Largest:
    """A sink that keeps the size of the largest message of each channel."""

    n_bytes: dict[str, int] = field(default_factory=dict)

    def write(self, channel: str, _utime: int, data: bytes) -> None:
        """Update the channel's maximum."""
        self.n_bytes[channel] = max(self.n_bytes.get(channel, 0), len(data))


def message_sizes(graph: Graph) -> list[MessageSize]:
    """Return the sizes of the messages that a graph receives and sends unthinned, largest first.

    In lockstep these are all channels, as sent by ``--tap full``. Sizes are measured: the graph runs for three ticks
    without log and network. Sizes of inputs are read from their logs.

    Raises
    ------
    GraphnavError
        A stage fails, or a log cannot be read.
    """
    measured = _measured(graph)
    if not graph.is_live:
        sizes = [MessageSize(channel, n_bytes) for channel, n_bytes in measured.items()]
    else:
        sent = {output.name: measured.get(output.channel.name) for output in graph.outputs.values()}
        sizes = [MessageSize(channel, n_bytes) for channel, n_bytes in sent.items() if n_bytes is not None]
        sizes += [size for given in graph.inputs.values() if (size := _of_input(given)) is not None]
    return sorted(sizes, key=lambda size: size.n_bytes, reverse=True)


def _measured(graph: Graph) -> dict[str, int]:
    """Run a few ticks; return the largest published message of each channel."""
    if not graph.sources:
        return {}
    largest = _Largest()
    bus = Bus()
    runner = Runner(graph, graph.make_stages(), bus, [largest])
    end_s = time.monotonic() + _MAX_S
    try:
        with third_party_code():
            runner.reset(graph.run.seed)
            runner.run(before_tick=lambda _: runner.ticks < _TICKS and time.monotonic() < end_s)
    finally:
        runner.close()
        bus.close()
    return largest.n_bytes


def _of_input(given: InputChannel) -> MessageSize | None:
    """Return the size in an input's log, an assumed size for a type with a pixel grid, None for small types."""
    if given.log is not None:
        with Recording(given.log) as recording:
            events = range(min(_FROM_LOG, recording.count(given.name)))
            sizes = [len(recording.event(given.name, index).data) for index in events]
        return MessageSize(given.name, max(sizes)) if sizes else None
    if given.channel.message.grid:
        return MessageSize(given.name, _ASSUMED_IMAGE_BYTES, "640x480 RGB")
    return None
