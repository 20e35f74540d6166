"""Benchmark the full-screen spy beside a paced run: CPU time of its process, with table and with picture."""

from __future__ import annotations

import argparse
import fcntl
import os
import pty
import struct
import subprocess
import sysconfig
import tempfile
import termios
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from taking_turns import load_told

GRAPHNAV = str(Path(sysconfig.get_path("scripts")) / "graphnav")
GRAPH = "corridor_ccw"
LIMIT = 0.15
_TICK_S = 1 / os.sysconf("SC_CLK_TCK")
_SETTLE_S = 6.0


def measure(seconds: float, keys: bytes, graphics: str = "blocks", rows: int = 50, cols: int = 200) -> float:
    """Return the share of a core that the spy takes beside a run, after some keys were pressed."""
    with tempfile.TemporaryDirectory() as folder, _run(folder, seconds + 3 * _SETTLE_S):
        time.sleep(_SETTLE_S / 2)
        with spy_in_terminal(["--graphics", graphics], folder, rows, cols) as (process, terminal):
            time.sleep(_SETTLE_S)
            for key in keys:
                os.write(terminal, bytes([key]))
                time.sleep(0.3)
            time.sleep(_SETTLE_S / 2)
            begin_s, begin_cpu_s = time.monotonic(), cpu_s(process.pid)
            time.sleep(seconds)
            return (cpu_s(process.pid) - begin_cpu_s) / (time.monotonic() - begin_s)


@contextmanager
def _run(folder: str, seconds: float) -> Iterator[None]:
    command = [GRAPHNAV, "run", GRAPH, "--pace", "1", "--until", str(seconds), "-o", f"{folder}/run"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            yield
        finally:
            process.terminate()


@contextmanager
def spy_in_terminal(
    arguments: Sequence[str], folder: str, rows: int, cols: int
) -> Iterator[tuple[subprocess.Popen[bytes], int]]:
    """Run the spy in a terminal of a size, whose output is dropped; yield the process and its keyboard."""
    terminal, screen = pty.openpty()
    fcntl.ioctl(screen, termios.TIOCSWINSZ, struct.pack("HHHH", rows, cols, 10 * cols, 20 * rows))
    looks = {**os.environ, "TERM": "xterm-256color", "COLORTERM": "truecolor"}
    command = [GRAPHNAV, "spy", *arguments]
    with subprocess.Popen(
        command, stdin=screen, stdout=screen, stderr=screen, env=looks, cwd=folder, start_new_session=True
    ) as process:
        os.close(screen)
        threading.Thread(target=_drain, args=(terminal,), daemon=True).start()
        try:
            yield process, terminal
        finally:
            process.terminate()


def _drain(terminal: int) -> None:
    try:
        while os.read(terminal, 1 << 16):
            pass
    except OSError:
        return


def cpu_s(pid: int) -> float:
    """Return the CPU time that a process has taken."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) * _TICK_S


def main() -> int:
    """Measure the table, then the table and a picture; return 1 where that is more than the limit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--channel", default="robot.image", help="the channel that is opened")
    parser.add_argument("--graphics", default="blocks", choices=("blocks", "sixel", "kitty"))
    args = parser.parse_args()
    table = measure(args.seconds, b"")
    picture = measure(args.seconds, b"/" + args.channel.encode() + b"\r\r", args.graphics)
    print(f"table {table:.1%} of a core, {args.channel} open by {args.graphics} {picture:.1%} (limit {LIMIT:.0%})")
    return 0 if max(table, picture) <= LIMIT else 1


if __name__ == "__main__":
    with load_told():
        raise SystemExit(main())
