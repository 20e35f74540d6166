"""Benchmark motor channels: commands through the sending process, and stops after the run was killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np
from taking_turns import load_told, results_in_turn

from graphnav.core.bus import Bus
from graphnav.core.codec import decode, encode
from graphnav.core.messages import Twist
from graphnav.live.motors.offsets import offsets_of
from graphnav.live.motors.sender import MotorChannel, MotorSender

URL = "udpm://239.255.77.251:7797?ttl=0"
CHANNEL = "BENCH_MOTOR"
N_COMMANDS, N_ROUNDS, N_KILLS = 500, 4, 20


class Receiver:
    """Another program that is driven: its own LCM object on the group."""

    def __init__(self) -> None:
        self.heard: list[tuple[float, bool]] = []
        self._bus = Bus(URL)
        self._bus.subscribe(CHANNEL, self._hear)

    def wait_for(self, is_true: Callable[[], object]) -> None:
        """Receive until something is true; raises TimeoutError after 30 s."""
        until_s = time.monotonic() + 30.0
        while not is_true():
            self._bus.handle(0.1)
            if time.monotonic() > until_s:
                raise TimeoutError("no message came")

    def delays_s(self, send: Callable[[bytes], object]) -> list[float]:
        """Return from call to arrival, for many commands one after another."""
        delays_s = []
        for seq in range(N_COMMANDS):
            data = encode(Twist(0.5, 0.0), seq, seq)
            self.heard.clear()
            start_s = time.monotonic()
            send(data)
            self.wait_for(lambda: self.heard)
            delays_s.append(self.heard[0][0] - start_s)
            time.sleep(0.002)
        return delays_s

    def _hear(self, _channel: str, data: bytes) -> None:
        self.heard.append((time.monotonic(), decode(Twist, data)[2].v_mps == 0.0))


def channel_of(max_age_s: float) -> MotorChannel:
    """Return the channel that is measured."""
    stamp_at, seq_at = offsets_of(Twist.lcm_class)
    return MotorChannel(CHANNEL, encode(Twist(0.0, 0.0), 0, 0), stamp_at, seq_at, max_age_s)


def drive() -> None:
    """Send commands until killed."""
    sender = MotorSender(URL, [channel_of(10.0)])
    while True:
        sender.send(CHANNEL, encode(Twist(0.5, 0.0), 0, 0))
        time.sleep(0.02)


def first_stop_s(receiver: Receiver, pause_s: float) -> float:
    """Return the time from a `kill -9` of a program that drives to the first stop."""
    with subprocess.Popen([sys.executable, __file__, "drive"]) as driver:
        receiver.heard.clear()
        receiver.wait_for(lambda: any(not is_stop for _, is_stop in receiver.heard))
        until_s = time.monotonic() + pause_s
        receiver.wait_for(lambda: time.monotonic() > until_s)
        receiver.heard.clear()
        killed_s = time.monotonic()
        os.kill(driver.pid, signal.SIGKILL)
        receiver.wait_for(lambda: any(is_stop for _, is_stop in receiver.heard))
        stop_s = next(at_s for at_s, is_stop in receiver.heard if is_stop)
        until_s = stop_s + 1.2
        receiver.wait_for(lambda: time.monotonic() > until_s)
        assert all(is_stop for at_s, is_stop in receiver.heard if at_s >= stop_s)
        return stop_s - killed_s


def report(what: str, delays_s: list[float]) -> None:
    """Print a distribution."""
    p50, p99, worst = np.percentile(delays_s, [50, 99, 100]) * 1e6
    print(f"{what:<32} p50 {p50:7.0f} us   p99 {p99:7.0f} us   max {worst:7.0f} us   n {len(delays_s)}", flush=True)


def main() -> None:
    """Measure, taking turns, and print."""
    receiver, direct = Receiver(), Bus(URL)
    sender = MotorSender(URL, [channel_of(60.0)])
    rivals = {
        "published directly": lambda: receiver.delays_s(lambda data: direct.publish(CHANNEL, data)),
        "through the sending process": lambda: receiver.delays_s(lambda data: sender.send(CHANNEL, data)),
    }
    found = results_in_turn(rivals, N_ROUNDS)
    sender.close()
    for name, rounds in found.items():
        report(name, [delay_s for delays_s in rounds for delay_s in delays_s])
    rng = np.random.default_rng(0)
    report("kill -9 to the first stop", [first_stop_s(receiver, rng.uniform(0.0, 0.1)) for _ in range(N_KILLS)])


if __name__ == "__main__":
    if sys.argv[1:] == ["drive"]:
        drive()
    else:
        with load_told():
            main()
