"""Hostile traffic while the full-screen spy, record and view run: all is counted, memory is bounded, nothing crashes.

10^6 mutated and truncated messages in valid packets and 10^6 packets of garbage, from ``tools/flood_spy.py``; names and
strings hold escapes of terminals, markup of rich and of HTML, and control characters. Among the garbage are packets
that LCM itself takes for messages: they count as such. One packet is left out: magic LC02 and a sequence number, 8
bytes, with no zero byte behind them (`4c 43 30 32 00 00 00 01`). liblcm 1.5 reads beyond its end, which ends any
process that listens, bare python-lcm as well. graphnav keeps it from liblcm (tests/lcm/test_packet_filter.py); here it
would count among the dropped packets, and the sum would prove less.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest
from testbed.processes import group_port, group_url
from testbed.terminal import HAS_TMUX

from tests.targets import Targets

from .hostile_watchers import Counted, Watchers
from .sane_sender import CHANNEL, RATE_HZ, SaneSender

GROUP = 97
URL, PORT = group_url(GROUP), group_port(GROUP)
COUNT = 1_000_000
MAX_GROWTH_MB = 60.0
RATE_RATIO = 0.02
FLOOD = Path(__file__).resolve().parents[2] / "tools" / "flood_spy.py"
_LOOK_S = 1.0


@pytest.mark.skipif(not HAS_TMUX, reason="the spy has no terminal: tmux is not installed")
def test_hostile(targets: Targets) -> None:
    """Counts of each program of what was sent, its memory before, in the middle and at the end."""
    with Watchers(URL, PORT) as watchers, SaneSender(URL) as sane:
        n_garbage, memory_mb = _flood(COUNT, watchers.pids)
        dead = watchers.dead()
        assert not dead, "ended during the flood"
        shown = watchers.top_of_screen()
        rates = watchers.sane_rates_hz()
        sane.stop()
        dead = watchers.dead()
        counted = watchers.counted()
    sent = COUNT + n_garbage + sane.sent
    for_s = len(memory_mb["spy"])
    targets.say(
        f"sent {COUNT:,} mutated messages, {COUNT:,} packets of garbage, {n_garbage:,} of which are messages, and"
    )
    targets.say(f"{sane.sent:,} messages on {CHANNEL}: {sent:,} messages; the hostile ones in {for_s} s")
    for name, one in counted.items():
        _check_count(targets, name, one, sent)
    for name, rate_hz in rates.items():
        _check_rate(targets, name, rate_hz)
    for name, sizes_mb in memory_mb.items():
        _check_memory(targets, name, sizes_mb)
    targets.check(f"ended before the end: {', '.join(dead) or 'none'}", good=not dead)
    targets.say("the spy's screen at the end of the flood:")
    for line in shown:
        targets.say(f"| {line}")


def _flood(count: int, pids: Mapping[str, int]) -> tuple[int, dict[str, list[float]]]:
    """Flood; return how much of the garbage is messages, and each program's memory second by second, MB."""
    memory_mb: dict[str, list[float]] = {name: [] for name in pids}
    command = [sys.executable, str(FLOOD), "--send", URL, "--count", str(count)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as sender:
        while True:
            for name, pid in pids.items():
                memory_mb[name].append(_rss_mb(pid))
            try:
                text, _ = sender.communicate(timeout=_LOOK_S)
            except subprocess.TimeoutExpired:
                continue
            return int(text), memory_mb


def _rss_mb(pid: int) -> float:
    """Return a process's resident memory, 0 of one that has ended."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[1]) * 4096 / 1e6
    except OSError:
        return 0.0


def _check_count(targets: Targets, name: str, counted: Counted, sent: int) -> None:
    """Say what a program counted: no more than was sent, and what is missing at most what it says that was dropped."""
    missing = sent - counted.messages
    judged = "" if counted.undecodable is None else f", {counted.undecodable:,} of them undecodable"
    dropped = f"tells {counted.dropped_packets:,} packets dropped by the kernel"
    text = f"{name}: {counted.messages:,} messages{judged}; {missing:,} missing, {dropped}"
    targets.check(text, good=0 <= missing <= counted.dropped_packets)


def _check_rate(targets: Targets, name: str, rate_hz: float | None) -> None:
    good = rate_hz is not None and abs(rate_hz / RATE_HZ - 1) <= RATE_RATIO
    text = "no rate" if rate_hz is None else f"{rate_hz:.2f} Hz"
    targets.check(f"{name} tells {text} of {CHANNEL}, sent at {RATE_HZ:g} Hz", good=good)


def _check_memory(targets: Targets, name: str, memory_mb: Sequence[float]) -> None:
    """Say how a program's memory went; what it grows by after the first tenth of the flood is judged."""
    warm = memory_mb[len(memory_mb) // 10]
    growth_mb = max(memory_mb[len(memory_mb) // 10 :]) - warm
    middle, last = memory_mb[len(memory_mb) // 2], memory_mb[-1]
    text = f"{memory_mb[0]:.0f} MB before, {warm:.0f} after a tenth, {middle:.0f} in the middle, {last:.0f} at the end"
    growth = f"at most {growth_mb:+.0f} MB after the first tenth (limit {MAX_GROWTH_MB:+.0f})"
    targets.check(f"{name}: memory {text}; {growth}", good=growth_mb <= MAX_GROWTH_MB)
