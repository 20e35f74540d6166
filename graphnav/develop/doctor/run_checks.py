"""Run all checks of the doctor in order."""

from __future__ import annotations

from collections.abc import Iterator

from graphnav import Graph
from graphnav.develop.doctor.finding import Finding
from graphnav.develop.doctor.installation import extras, families, java, lcm_wheel, portable_logs, terminal_graphics
from graphnav.develop.doctor.network import multicast, receive_buffer


def run_checks(graph: Graph | None = None) -> Iterator[Finding]:
    """Yield the findings of all checks; the receive buffer is compared with the messages of ``graph``."""
    yield multicast()
    yield from receive_buffer(graph)
    yield lcm_wheel()
    yield java()
    yield portable_logs()
    yield terminal_graphics()
    yield from extras()
    yield from families()
