"""The size of the receive buffer that the kernel grants."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import parse_qs, urlsplit

_RMEM_MAX = Path("/proc/sys/net/core/rmem_max")


def buffer_notice(url: str) -> str:
    """Return a warning if the kernel grants less than the URL requests, else an empty string."""
    wanted = parse_qs(urlsplit(url).query).get("recv_buf_size", ["0"])[-1]
    try:
        wanted_bytes, granted_bytes = int(wanted), int(_RMEM_MAX.read_text())
    except (OSError, ValueError):
        return ""
    if granted_bytes >= wanted_bytes:
        return ""
    return (
        f"the kernel grants {granted_bytes} bytes of receive buffer, {wanted_bytes} are requested: large messages will "
        f"be lost\n  run as root: sysctl -w net.core.rmem_max={wanted_bytes}"
    )
