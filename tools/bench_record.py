"""Benchmark the losses of `graphnav record` and `graphnav spy` against raw python-lcm listening at the same time.

Three loads over udpm with recv_buf_size=2097152: 20,000 messages/s of 200 bytes, 60 images/s of 640x480 gray, and both.
Listening are a raw python-lcm logger, `record` and, in turn, `spy --json` and the full-screen spy where there is tmux:
more at once would ask for more than two cores. A message of each channel stands before and one behind a load, so that
every gap has two ends; what a listener has and what it says that it lost must then be what was sent.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import lcm
import numpy as np
from taking_turns import load_told
from testbed.drives import GRAPHNAV
from testbed.processes import await_listeners
from testbed.terminal import HAS_TMUX, SpyTerminal

from graphnav import Image, Recording
from graphnav.core.codec import encode
from graphnav.core.messages import Stop

PORT = 7983
URL = f"udpm://239.255.83.1:{PORT}?ttl=0&recv_buf_size=2097152"
SMALL, IMAGE = "small", "image"
RATES_HZ = {SMALL: 20_000, IMAGE: 60}
LOADS = ((SMALL,), (IMAGE,), (SMALL, IMAGE))
RAW, RECORD, SPY, SCREEN = "raw python-lcm", "record", "spy --json", "spy, full screen"
SPIES = (SPY, SCREEN) if HAS_TMUX else (SPY,)
SMALL_BYTES = 200
SETTLE_S = 2.0
_START_S = 20.0
"""How long the slowest listener may take to start on a busy machine."""
RAW_LOGGER = """
import signal, sys, time
import lcm
ending = []
signal.signal(signal.SIGTERM, lambda *_: ending.append(True))
log = lcm.EventLog(sys.argv[2], "w", overwrite=True)
bus = lcm.LCM(sys.argv[1])
hear = bus.subscribe(".*", lambda channel, data: log.write_event(int(time.time() * 1e6), channel, data))
hear.set_queue_capacity(0)
while not ending:
    try:
        bus.handle_timeout(50)
    except OSError:  # interrupted by the signal
        pass
log.close()
"""


@dataclass(frozen=True)
class Loss:
    """Messages of a channel received by a listener; ``says_lost``: None for raw python-lcm, which does not report."""

    load: str
    channel: str
    listener: str
    sent: int
    has: int
    says_lost: int | None

    @property
    def lost_ratio(self) -> float:
        """The share of the messages that were sent and that it does not have."""
        return 1 - self.has / self.sent

    @property
    def is_told(self) -> bool:
        """Whether all that is missing was told."""
        return self.says_lost is None or self.has + self.says_lost == self.sent

    def __str__(self) -> str:
        said = "" if self.says_lost is None else f"says {self.says_lost:,}" + ("" if self.is_told else ", NOT ALL")
        return (
            f"{self.load:12} {self.channel:8} {self.sent:9,} {self.has:9,} {self.sent - self.has:9,} "
            f"{100 * self.lost_ratio:8.3f} %  {self.listener:17} {said}"
        )


def messages() -> dict[str, bytes]:
    """Return a message of each load, numbered 0."""
    padding = SMALL_BYTES - len(encode(Stop(engaged=False, reason=""), 0, 0))
    pixels = np.random.default_rng(1).integers(0, 255, (480, 640), np.uint8)
    return {
        SMALL: encode(Stop(engaged=False, reason="x" * padding), 0, 0),
        IMAGE: encode(Image(pixels), 0, 0),
    }


def publish(channels: tuple[str, ...], duration_s: float) -> dict[str, int]:
    """Publish in real time, a message of each channel before and one behind; return how many of each were sent."""
    bus, data = lcm.LCM(URL), {channel: messages()[channel] for channel in channels}
    sent = dict.fromkeys(channels, 0)

    def send(channel: str) -> None:
        seq = sent[channel].to_bytes(8, "big")
        bus.publish(channel, data[channel][:16] + seq + data[channel][24:])
        sent[channel] += 1

    for channel in channels:
        send(channel)
    time.sleep(SETTLE_S)
    begin_s = time.monotonic()
    while (elapsed_s := time.monotonic() - begin_s) < duration_s:
        channel = min(channels, key=lambda one: sent[one] / RATES_HZ[one])
        wait_s = sent[channel] / RATES_HZ[channel] - elapsed_s
        if wait_s > 0.0005:  # some ten small messages at a time
            time.sleep(wait_s)
        send(channel)
    time.sleep(SETTLE_S)
    for channel in channels:
        send(channel)
    time.sleep(SETTLE_S)
    return sent


def measure(channels: tuple[str, ...], duration_s: float, folder: Path, spy: str = SPY) -> list[Loss]:
    """Publish to raw python-lcm, record and one of the spies at once; return what each has and says."""
    for_s = _START_S + 3 * SETTLE_S + duration_s + 5.0
    return listened("+".join(channels), (URL, PORT), lambda: publish(channels, duration_s), folder, spy, for_s)


def listened(
    load: str, group: tuple[str, int], send: Callable[[], dict[str, int]], folder: Path, spy: str, for_s: float
) -> list[Loss]:
    """Return what raw python-lcm, record and one of the spies have and say of what ``send`` sends on a group.

    ``group``: its URL and port. ``send`` returns how many messages of each channel were sent. ``for_s``: how long
    `spy --json` listens.
    """
    url, port = group
    logs = {RAW: folder / "raw", RECORD: folder / "record"}
    commands = {
        RAW: [sys.executable, "-c", RAW_LOGGER, url, str(logs[RAW])],
        RECORD: [str(GRAPHNAV), "record", url, "-o", str(logs[RECORD]), "--force"],
    }
    if spy == SPY:
        commands[SPY] = [str(GRAPHNAV), "spy", url, "--json", "--for", str(for_s)]
    screen = {}
    with ExitStack() as stack:
        processes = {
            name: stack.enter_context(subprocess.Popen(command, stdout=subprocess.PIPE, text=True))
            for name, command in commands.items()
        }
        terminal = stack.enter_context(SpyTerminal(url, 200, 50)) if spy == SCREEN else None
        await_listeners(port, len(processes) + (terminal is not None), _START_S)
        sent = send()
        if terminal is not None:
            screen = {channel: terminal.cells(channel) for channel in sent}
        for name in logs:
            processes[name].terminate()
        told = {name: process.communicate()[0] for name, process in processes.items()}
    return [
        Loss(load, channel, name, count, *found)
        for channel, count in sent.items()
        for name, found in _found(channel, logs, told, screen)
    ]


def _found(
    channel: str, logs: dict[str, Path], told: dict[str, str], screen: dict[str, dict[str, str]]
) -> Iterator[tuple[str, tuple[int, int | None]]]:
    """Yield what each listener has of a channel and what it says that it lost."""
    for name, path in logs.items():
        with Recording(path) as log:
            yield name, (log.count(channel), _lost_in_table(told[name], channel) if name == RECORD else None)
    if SPY in told:
        spied = json.loads(told[SPY])["channels"][channel]
        yield SPY, (spied["messages"], spied["lost"])
    if cells := screen.get(channel):
        yield SCREEN, (int(cells["messages"]), int(cells["drops"].replace("-", "0")))


def _lost_in_table(text: str, channel: str) -> int:
    """Return the last cell of a channel's line in record's closing table."""
    line = next(line for line in text.splitlines() if line.split()[:1] == [channel])
    return int(line.split()[-1].replace(",", ""))


def main() -> int:
    """Print the table; return 1 where something was lost and not told."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0, help="of each load (default: 10)")
    parser.add_argument("--rounds", type=int, default=4, help="how often each load is published (default: 4)")
    args = parser.parse_args()
    print(f"{'load':12} {'channel':8} {'sent':>9} {'has':>9} {'lost':>9} {'':>10}  listener")
    is_told = True
    for number in range(args.rounds):
        for channels in LOADS:
            with tempfile.TemporaryDirectory() as folder:
                for loss in measure(channels, args.seconds, Path(folder), SPIES[number % len(SPIES)]):
                    is_told &= loss.is_told
                    print(loss, flush=True)
    return 0 if is_told else 1


if __name__ == "__main__":
    with load_told():
        sys.exit(main())
