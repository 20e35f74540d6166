"""Check that the network carries LCM messages between programs, of the sizes that a graph exchanges."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple
from urllib.parse import urlsplit

from graphnav import Graph, GraphnavError, Source, UserError
from graphnav.core.bus import Bus
from graphnav.core.errors import BusError, NoRouteError
from graphnav.core.interrupts import third_party_code
from graphnav.core.lcm_url import live_url, tap_url
from graphnav.core.machine import ReceiveBuffer
from graphnav.core.runner import Lockstep, size_text
from graphnav.develop.doctor.finding import Finding

_PROBE_PORT = 17667
_WAIT_S = 1.0
_SUBJECT = "receive buffer"
_TICKS = 3
"""The first tick has no flow, the second has all messages."""
_MAX_S = 10.0
_ASSUMED_IMAGE_BYTES = 640 * 480 * 3


def multicast() -> Finding:
    """Send a message to the tap's multicast group, on a separate port, and check that it comes back."""
    try:
        url = tap_url()
    except UserError as error:
        problem = error.problems[0]
        fix = Bus.MAKE_ROUTE if isinstance(error.__cause__, NoRouteError) else str(problem.hint)
        where = f"{problem.place}: " if problem.place else ""
        return Finding("multicast", fine=False, seen=where + problem.what, fix=fix)
    if not _comes_back(f"udpm://{urlsplit(url).hostname}:{_PROBE_PORT}?ttl=0"):
        seen = f"there is a route to {url}, but a test message did not come back"
        return Finding("multicast", fine=False, seen=seen, fix=Bus.MAKE_ROUTE)
    return Finding("multicast", fine=True, seen="a test message came back: runs can be watched")


def _comes_back(url: str) -> bool:
    received: list[bytes] = []
    try:
        bus = Bus(url)
        try:
            bus.subscribe("graphnav.doctor", lambda _, data: received.append(data))
            bus.publish("graphnav.doctor", b"")
            end_s = time.monotonic() + _WAIT_S
            while not received and (left_s := end_s - time.monotonic()) > 0:
                bus.handle(left_s)
        finally:
            bus.close()
    except BusError:
        return False
    return bool(received)


def receive_buffer(graph: Graph | None) -> Iterator[Finding]:
    """Measure the receive buffer that the URL requests, and compare it with the messages that ``graph`` receives.

    What graphnav itself sends leaves with gaps, so that every buffer holds it; without a graph the finding is an extra.
    """
    url = _url(graph)
    asked_bytes = Bus.requested_buffer(url)
    try:
        limit = ReceiveBuffer.limit()
        buffer = ReceiveBuffer.measured(asked_bytes)
    except OSError as error:
        yield Finding(_SUBJECT, fine=False, seen=f"cannot be measured: {error}")
        return
    holds = (
        f"holds messages up to {size_text(buffer.held_bytes)} of senders that leave no gaps, with recv_buf_size="
        f"{asked_bytes} of {url.partition('?')[0]} (net.core.rmem_max is {limit})"
    )
    if graph is None:
        fix = str(ReceiveBuffer.larger(asked_bytes, ReceiveBuffer.REQUESTED_BYTES))
        yield Finding(_SUBJECT, fine=not fix, seen=holds, fix=fix, needed=False)
        return
    try:
        sizes = message_sizes(graph)
    except GraphnavError as error:
        yield Finding(_SUBJECT, fine=False, seen=f"{holds}; the graph's messages cannot be measured: {error}")
        return
    yield _compared(graph, sizes, buffer, asked_bytes, holds)


def _url(graph: Graph | None) -> str:
    """Return the URL on which the graph, or else a viewer, receives."""
    try:
        return live_url(graph, None) if graph is not None and graph.is_live else tap_url()
    except UserError:  # `multicast` reports it
        return Bus.with_defaults(Bus.GROUP)


def _compared(graph: Graph, sizes: list[MessageSize], buffer: ReceiveBuffer, asked_bytes: int, holds: str) -> Finding:
    name = graph.path.stem
    lost = [size for size in sizes if size.is_received and size.n_bytes > buffer.held_bytes]
    if lost:
        fix = str(ReceiveBuffer.larger(asked_bytes, ReceiveBuffer.needed(lost[0].n_bytes)))
        seen = f"{holds}; {name} loses {', '.join(map(_text, lost))}"
        return Finding(_SUBJECT, fine=False, seen=seen, fix=fix)
    if received := [size for size in sizes if size.is_received]:
        holds += f"; {name} needs {_text(received[0])}"
    if with_gaps := [size for size in sizes if size.n_bytes > buffer.held_bytes]:
        condition = "" if graph.is_live else "with --tap full "
        holds += f"; {name} sends {condition}{', '.join(map(_text, with_gaps))}, with gaps"
    return Finding(_SUBJECT, fine=True, seen=holds)


def _text(size: MessageSize) -> str:
    return f"{size_text(size.n_bytes)} for {size.channel}" + (f" (assumed: {size.assumed})" if size.assumed else "")


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
        sent = {
            output.name: measured.get(output.channel.name)
            for output in graph.outputs.values()
            if output.ros_type is None
        }
        sizes = [MessageSize(channel, n_bytes) for channel, n_bytes in sent.items() if n_bytes is not None]
        sizes += [
            MessageSize(given.name, _ASSUMED_IMAGE_BYTES, is_received=True, assumed="640x480 RGB")
            for given in graph.inputs.values()
            if given.is_channel and given.channel.message.grid
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
