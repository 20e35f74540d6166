"""Measure the sizes of the messages that a graph exchanges with other programs."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import NamedTuple

from graphnav import Graph, Source
from graphnav.core.interrupts import third_party_code
from graphnav.core.runner import Lockstep

_TICKS = 3
"""The first tick has no flow, the second has all messages."""
_MAX_S = 10.0
_ASSUMED_IMAGE_BYTES = 640 * 480 * 3


class MessageSize(NamedTuple):
    """The largest message of a channel; ``assumed``: the assumption made if the size is not known in advance.

    ``is_received``: whether other programs send it.
    """

    channel: str
    n_bytes: int
    is_received: bool = False
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
    without log and network. Inputs that are played from logs need no network.

    Raises
    ------
    GraphnavError
        A stage fails.
    """
    measured = _measured(graph)
    if not graph.is_live:
        sizes = [MessageSize(channel, n_bytes) for channel, n_bytes in measured.items()]
    else:
        sent = {output.name: measured.get(output.channel.name) for output in graph.outputs.values()}
        sizes = [MessageSize(channel, n_bytes) for channel, n_bytes in sent.items() if n_bytes is not None]
        sizes += [
            MessageSize(given.name, _ASSUMED_IMAGE_BYTES, is_received=True, assumed="640x480 RGB")
            for given in graph.inputs.values()
            if given.log is None and given.channel.message.grid
        ]
    return sorted(sizes, key=lambda size: size.n_bytes, reverse=True)


def _measured(graph: Graph) -> dict[str, int]:
    """Run a few ticks; return the largest published message of each channel. Sources on other machines do not run."""
    stages = graph.make_stages()
    sources = [stages[node.name] for node in graph.sources]
    if not sources or any(isinstance(source, Source) and source.is_remote() for source in sources):
        return {}
    largest = _Largest()
    lockstep = Lockstep(graph, stages, [largest])
    end_s = time.monotonic() + _MAX_S
    try:
        with third_party_code():
            lockstep.reset(graph.run.seed)
            lockstep.run(before_tick=lambda _: lockstep.engine.ticks < _TICKS and time.monotonic() < end_s)
    finally:
        lockstep.engine.close()
    return largest.n_bytes
