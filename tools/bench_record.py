"""What `graphnav record` loses, beside what a raw python-lcm logger loses that listens at the same time.

Three loads over udpm with recv_buf_size=2097152: 20,000 messages/s of 200 bytes, 60 images/s of 640x480 gray, and both.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import sysconfig
import tempfile
import time
from pathlib import Path

import lcm
import numpy as np

from graphnav import Image, Recording
from graphnav.codec import encode
from graphnav.messages import Stop

URL = "udpm://239.255.83.1:7983?ttl=0&recv_buf_size=2097152"
GRAPHNAV = str(Path(sysconfig.get_path("scripts")) / "graphnav")
SMALL, IMAGE = "small", "image"
RATES_HZ = {SMALL: 20_000, IMAGE: 60}
LOADS = ((SMALL,), (IMAGE,), (SMALL, IMAGE))
SMALL_BYTES = 200
SETTLE_S = 1.0
RAW_LOGGER = """
import signal, sys, time
import lcm
ending = []
signal.signal(signal.SIGTERM, lambda *_: ending.append(True))
log = lcm.EventLog(sys.argv[2], "w", overwrite=True)
bus = lcm.LCM(sys.argv[1])
hear = bus.subscribe(".*", lambda channel, data: log.write_event(int(time.time() * 1e6), channel, data))
hear.set_queue_capacity(0)
print("listening", flush=True)
while not ending:
    try:
        bus.handle_timeout(50)
    except OSError:  # interrupted by the signal
        pass
log.close()
"""


def messages() -> dict[str, bytes]:
    """Return a message of each load, numbered 0."""
    padding = SMALL_BYTES - len(encode(Stop(engaged=False, reason=""), 0, 0))
    pixels = np.random.default_rng(1).integers(0, 255, (480, 640), np.uint8)
    return {
        SMALL: encode(Stop(engaged=False, reason="x" * padding), 0, 0),
        IMAGE: encode(Image(pixels), 0, 0),
    }


def publish(channels: tuple[str, ...], duration_s: float) -> tuple[dict[str, int], float]:
    """Publish in real time; return how many messages of each channel, and how long it took."""
    bus, data = lcm.LCM(URL), {channel: messages()[channel] for channel in channels}
    sent = dict.fromkeys(channels, 0)
    begin_s = time.monotonic()
    while min(sent[channel] / RATES_HZ[channel] for channel in channels) < duration_s:
        channel = min(channels, key=lambda one: sent[one] / RATES_HZ[one])
        wait_s = begin_s + sent[channel] / RATES_HZ[channel] - time.monotonic()
        if wait_s > 0.0005:  # twenty small messages at a time
            time.sleep(wait_s)
        head, seq = data[channel][:16], sent[channel].to_bytes(8, "big")
        bus.publish(channel, head + seq + data[channel][24:])
        sent[channel] += 1
    return sent, time.monotonic() - begin_s


def measure(channels: tuple[str, ...], duration_s: float, folder: Path) -> list[str]:
    """Publish to both loggers at once; return the rows of the table."""
    logs = {"graphnav record": folder / "ours", "raw python-lcm": folder / "theirs"}
    commands = {
        "graphnav record": [GRAPHNAV, "record", URL, "-o", str(folder / "ours"), "--force"],
        "raw python-lcm": [sys.executable, "-c", RAW_LOGGER, URL, str(folder / "theirs")],
    }
    processes = {
        name: subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        for name, command in commands.items()
    }
    for process in processes.values():
        assert process.stdout is not None
        process.stdout.readline()
    time.sleep(SETTLE_S)
    sent, took_s = publish(channels, duration_s)
    time.sleep(SETTLE_S)
    for process in processes.values():
        process.terminate()
    told = {name: process.communicate(timeout=60)[0] for name, process in processes.items()}
    rows = []
    for name, path in logs.items():
        with Recording(path) as log:
            heard = {channel: log.count(channel) for channel in channels}
        for channel, n in sent.items():
            lost = n - heard[channel]
            rows.append(
                f"{'+'.join(channels):12} {channel:8} {n / took_s:9.0f}/s {n:9,} {heard[channel]:9,} {lost:9,} "
                f"{100 * lost / n:8.3f} %  {name}"
            )
    said = next(line for line in told["graphnav record"].splitlines() if " messages, " in line)
    return [*rows, f"  record says: {said}"]


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0, help="of each load (default: 10)")
    parser.add_argument("--rounds", type=int, default=3, help="how often each load is published (default: 3)")
    args = parser.parse_args()
    print(f"{'load':12} {'channel':8} {'rate':>11} {'sent':>9} {'in log':>9} {'lost':>9} {'':>10}  logger")
    for _ in range(args.rounds):
        for channels in LOADS:
            with tempfile.TemporaryDirectory() as folder:
                print("\n".join(measure(channels, args.seconds, Path(folder))), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
