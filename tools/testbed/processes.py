"""Programs in processes of their own: started, awaited, heard on LCM, ended."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import lcm
from graphnav_lcm import twist_t

from testbed.drives import GRAPHNAV

PATIENCE_S = 60.0
_UDP = Path("/proc/net/udp")
_ADDRESS = 1
"""A column of /proc/net/udp."""


def group_url(number: int) -> str:
    """Return the URL of a multicast group of this number, which no rig uses."""
    return f"udpm://239.255.82.{number}:{group_port(number)}?ttl=0"


def group_port(number: int) -> int:
    """Return the port of a multicast group of this number."""
    return 8100 + number


def graphnav_run(graph: str | Path, url: str, folder: Path, *options: str) -> list[str]:
    """Return the command of a live run without tap and pictures."""
    fixed = ["--url", url, "--no-tap", "--no-pictures", "-o", str(folder)]
    return [str(GRAPHNAV), "run", str(graph), *fixed, *options]


def python(script: Path, *arguments: str) -> list[str]:
    """Return the command of a Python program."""
    return [sys.executable, str(script), *arguments]


@contextmanager
def running(command: Sequence[str], output: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Start a program that prints to a file; interrupt it at the end, and wait for it."""
    with output.open("wb") as file:
        process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)
    try:
        yield process
    finally:
        end(process)


def end(process: subprocess.Popen[Any]) -> None:
    """End a program as Ctrl-C does; kill it if it does not end."""
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def hear(url: str, channel: str, holds: Callable[[bytes], bool] = lambda _: True) -> None:
    """Wait for a message on a channel for which ``holds`` is true; raise TimeoutError if none comes."""
    found: list[bool] = []
    ear = lcm.LCM(url)
    ear.subscribe(channel, lambda _, data: found.append(holds(data)))
    end_s = time.monotonic() + PATIENCE_S
    while not any(found):
        if time.monotonic() > end_s:
            raise TimeoutError(f"nothing came on {channel} of {url} within {PATIENCE_S:g} s")
        ear.handle_timeout(100)


def await_file(path: Path) -> None:
    """Wait until a program has made a file; raise TimeoutError if it does not."""
    end_s = time.monotonic() + PATIENCE_S
    while not path.exists():
        if time.monotonic() > end_s:
            raise TimeoutError(f"there is no {path} after {PATIENCE_S:g} s")
        time.sleep(0.02)


def drives_forward(data: bytes) -> bool:
    """Whether a ``twist_t`` goes forward."""
    return bool(twist_t.decode(data).v_mps > 0)


def count_listeners(port: int) -> int:
    """Return how many sockets are bound to a UDP port of this machine, as the kernel tells."""
    rows = [line.split() for line in _UDP.read_text(encoding="ascii").splitlines()[1:]]
    return sum(int(row[_ADDRESS].rpartition(":")[2], 16) == port for row in rows)


def await_listeners(port: int, count: int, for_s: float) -> None:
    """Wait until so many sockets are bound to a port; raise TimeoutError if they are not in time."""
    end_s = time.monotonic() + for_s
    while count_listeners(port) < count:
        if time.monotonic() > end_s:
            raise TimeoutError(f"{count_listeners(port)} of {count} programs listen on port {port} after {for_s:g} s")
        time.sleep(0.1)
