"""Memory that is freed stays with the process: fresh pages cost several times what it costs to write to used ones."""

from __future__ import annotations

import ctypes
from contextlib import suppress

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
"""Of ``mallopt``, in glibc's ``malloc.h``."""
_KEPT_BYTES = 64 << 20
_LARGEST_BYTES = 32 << 20
"""The highest limit that glibc takes: larger buffers are the kernel's again as soon as they are freed."""


def keep_freed_memory() -> None:
    """Let the C library keep up to 64 MiB of what is freed for what comes next, where it is glibc.

    By default a picture from 128 kB on gets fresh pages from the kernel and returns them when it is dropped, so that
    each of the next is paid for again.
    """
    with suppress(OSError, TypeError, AttributeError):  # on other systems there is no such call
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(_TRIM_THRESHOLD, _KEPT_BYTES)
        mallopt(_MMAP_THRESHOLD, _LARGEST_BYTES)
