"""A process keeps what it frees, so that the next message finds pages that are there."""

from __future__ import annotations

import subprocess
import sys

import pytest

FAULTS = """
import resource, sys
from graphnav.processes.frames import keep_freed_memory
if sys.argv[1] == "keep":
    keep_freed_memory()
def twice():
    return bytes(bytearray(1_000_000))
for _ in range(5):
    twice()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(20):
    twice()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def faults(how: str) -> int:
    """Return how many pages 20 pairs of buffers of a megabyte take from the kernel."""
    done = subprocess.run([sys.executable, "-c", FAULTS, how], check=True, capture_output=True, text=True)
    return int(done.stdout)


@pytest.mark.skipif(sys.platform != "linux", reason="the C library is another one")
def test_buffers_get_pages_that_were_freed_before() -> None:
    assert faults("keep") < 50 < faults("leave")
