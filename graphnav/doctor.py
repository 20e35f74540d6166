"""What this machine lacks for LCM and for the installed plugins, with the command that mends it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from graphnav.bus import GROUP, RECEIVE_BUFFER_BYTES, require_route
from graphnav.catalog import Catalog
from graphnav.errors import BusError, CatalogError

_RMEM_MAX = Path("/proc/sys/net/core/rmem_max")


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at: whether it is fine, what was seen, and the command that mends it."""

    subject: str
    fine: bool
    seen: str
    mend: str = ""


def examine() -> Iterator[Finding]:
    """Look at everything, one finding after another."""
    yield _multicast()
    yield _receive_buffer()
    yield from _families()


def _multicast() -> Finding:
    try:
        require_route(GROUP)
    except BusError as error:
        what, _, mend = str(error).partition("\n")
        return Finding("multicast", fine=False, seen=what, mend=mend.strip())
    return Finding("multicast", fine=True, seen="there is a route: runs can be watched by spies and loggers")


def _receive_buffer() -> Finding:
    try:
        most = int(_RMEM_MAX.read_text())
    except (OSError, ValueError) as error:
        return Finding("receive buffer", fine=False, seen=f"cannot read {_RMEM_MAX}: {error}")
    if most < RECEIVE_BUFFER_BYTES:
        return Finding(
            "receive buffer",
            fine=False,
            seen=f"the kernel grants at most {most} bytes: large messages (--tap full) will be lost",
            mend=f"sysctl -w net.core.rmem_max={RECEIVE_BUFFER_BYTES}",
        )
    return Finding("receive buffer", fine=True, seen=f"the kernel grants up to {most} bytes")


def _families() -> Iterator[Finding]:
    catalog = Catalog()
    for family in catalog.families():
        try:
            names = catalog.names(family)
        except CatalogError as error:
            yield Finding(f"family {family}", fine=False, seen=error.what, mend=error.hint or "reinstall its package")
        else:
            yield Finding(f"family {family}", fine=True, seen=", ".join(names) or "no stages")
