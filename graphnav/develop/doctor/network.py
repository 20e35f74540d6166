"""Check that the network carries LCM messages between programs."""

from __future__ import annotations

import time
from collections.abc import Iterator
from urllib.parse import urlsplit

from graphnav import Graph, GraphnavError, UserError
from graphnav.core.bus import Bus
from graphnav.core.errors import BusError, NoRouteError
from graphnav.core.lcm_url import live_url, tap_url
from graphnav.core.machine import ReceiveBuffer
from graphnav.core.runner import size_text
from graphnav.develop.doctor.finding import Finding
from graphnav.develop.doctor.message_sizes import MessageSize, message_sizes

_PROBE_PORT = 17667
_WAIT_S = 1.0
_SUBJECT = "receive buffer"


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
