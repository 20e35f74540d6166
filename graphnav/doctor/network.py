"""Check that the network carries LCM messages between programs."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

from graphnav.bus import MAKE_ROUTE, RECEIVE_BUFFER_BYTES, Bus
from graphnav.doctor.finding import Finding
from graphnav.doctor.message_sizes import MessageSize, message_sizes
from graphnav.doctor.receive_buffer import ReceiveBuffer, try_receive_buffer
from graphnav.errors import BusError, GraphnavError, NoRouteError, UserError
from graphnav.graph import Graph
from graphnav.lcm_url import tap_url
from graphnav.runner.recording.log_forecast import size_text

_RMEM_MAX = Path("/proc/sys/net/core/rmem_max")
_PROBE_PORT = 17667
_WAIT_S = 1.0
_SUBJECT = "receive buffer"


def multicast() -> Finding:
    """Send a message to the tap's multicast group, on a separate port, and check that it comes back."""
    try:
        url = tap_url()
    except UserError as error:
        problem = error.problems[0]
        fix = MAKE_ROUTE if isinstance(error.__cause__, NoRouteError) else str(problem.hint)
        where = f"{problem.place}: " if problem.place else ""
        return Finding("multicast", fine=False, seen=where + problem.what, fix=fix)
    if not _comes_back(f"udpm://{urlsplit(url).hostname}:{_PROBE_PORT}?ttl=0"):
        seen = f"there is a route to {url}, but a test message did not come back"
        return Finding("multicast", fine=False, seen=seen, fix=MAKE_ROUTE)
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
    """Measure the receive buffer; compare it with the messages of ``graph``, else with the size graphnav requests.

    A buffer too small for a lockstep graph is an extra: without ``--tap full`` every message fits one packet.
    """
    try:
        limit = int(_RMEM_MAX.read_text())
        buffer = try_receive_buffer()
    except (OSError, ValueError) as error:
        yield Finding(_SUBJECT, fine=False, seen=f"cannot be measured: {error}")
        return
    holds = f"the kernel buffers messages up to {size_text(buffer.held_bytes)} (net.core.rmem_max is {limit})"
    if graph is None:
        fine = limit >= RECEIVE_BUFFER_BYTES
        lost = "" if fine else "; larger ones, as sent by --tap full, are lost"
        yield Finding(_SUBJECT, fine, holds + lost, "" if fine else _raise_to(RECEIVE_BUFFER_BYTES))
        return
    try:
        sizes = message_sizes(graph)
    except GraphnavError as error:
        yield Finding(_SUBJECT, fine=False, seen=f"{holds}; the graph's messages cannot be measured: {error}")
        return
    yield _compared(graph, sizes, buffer, holds)


def _compared(graph: Graph, sizes: list[MessageSize], buffer: ReceiveBuffer, holds: str) -> Finding:
    lost = [size for size in sizes if size.n_bytes > buffer.held_bytes]
    condition = "" if graph.is_live else " with --tap full"
    if not lost:
        largest = f"; {graph.path.stem} needs {_text(sizes[0])}{condition}" if sizes else ""
        return Finding(_SUBJECT, fine=True, seen=holds + largest)
    seen = f"{holds}; {graph.path.stem} loses{condition} {', '.join(map(_text, lost))}"
    needed_bytes = max(RECEIVE_BUFFER_BYTES, buffer.needed_bytes(lost[0].n_bytes))
    if needed_bytes > RECEIVE_BUFFER_BYTES:
        seen += f"; its URL, and those of all receivers, also need recv_buf_size={needed_bytes}"
    return Finding(_SUBJECT, fine=False, seen=seen, fix=_raise_to(needed_bytes), needed=graph.is_live)


def _raise_to(n_bytes: int) -> str:
    return f"sysctl -w net.core.rmem_max={n_bytes}"


def _text(size: MessageSize) -> str:
    return f"{size_text(size.n_bytes)} for {size.channel}" + (f" (assumed: {size.assumed})" if size.assumed else "")
