"""Run all checks of the doctor in order."""

from __future__ import annotations

from collections.abc import Iterator

from graphnav import Graph
from graphnav.develop.doctor.extras import extras
from graphnav.develop.doctor.finding import Finding
from graphnav.develop.doctor.installed_programs import java, lcm_wheel
from graphnav.develop.doctor.instruction_set import portable_logs
from graphnav.develop.doctor.network import multicast, receive_buffer
from graphnav.develop.doctor.plugin_families import families
from graphnav.develop.doctor.terminal import terminal_graphics


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
