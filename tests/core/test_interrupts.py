"""A signal ends a wait, whenever in the wait it comes."""

from __future__ import annotations

import subprocess
import sys

EACH_LINE = """
import os, signal, sys
from graphnav.core.interrupts import Interrupt

def asked_at(line):
    n = 0
    def trace(frame, event, _):
        nonlocal n
        if event == "line":
            n += 1
            if n == line:
                sys.settrace(None)
                os.kill(os.getpid(), signal.SIGTERM)
        return trace
    with Interrupt() as interrupt:
        sys.settrace(trace)
        interrupt.wait(0.001)
        sys.settrace(None)
        return interrupt.asked

lines = 0
while asked_at(lines + 1):
    lines += 1
with Interrupt() as interrupt:
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    interrupt.wait(1e6)
    interrupt.wait(1e6)
    interrupt.wait(-1.0)
print(lines, interrupt.asked)
"""


def test_a_signal_at_any_line_of_a_wait_ends_it_and_all_that_follow() -> None:
    done = subprocess.run([sys.executable, "-c", EACH_LINE], capture_output=True, text=True, timeout=60, check=True)
    lines, asked = done.stdout.split()
    assert int(lines) >= 1
    assert asked == "True"
