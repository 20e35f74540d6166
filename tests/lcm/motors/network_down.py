"""A program that sends commands in a network of its own, which it takes down and up again."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable

from graphnav.core.codec import encode
from graphnav.core.messages import Twist
from graphnav.live.health.motor_traffic import MotorTraffic
from graphnav.live.motors.sender import MotorChannel, MotorSender


def ip(*words: str) -> None:
    """Configure the network."""
    subprocess.run(["ip", *words], check=True)


def send_until(sender: MotorSender, is_true: Callable[[], bool]) -> None:
    """Send commands until something is true."""
    until_s = time.monotonic() + 30.0
    while not is_true():
        assert time.monotonic() < until_s, sender.counts
        sender.send("M", encode(Twist(0.5, 0.0), 0, 0))
        time.sleep(0.01)


def main() -> None:
    """Lose the network and get it back."""
    ip("link", "set", "lo", "up", "multicast", "on")
    ip("route", "add", "224.0.0.0/4", "dev", "lo")
    sender = MotorSender(
        "udpm://239.255.76.67:7667?ttl=0", [MotorChannel("M", encode(Twist(0.0, 0.0), 0, 0), 8, 16, 0.1)]
    )
    traffic = MotorTraffic()
    traffic.motors = sender
    send_until(sender, lambda: sender.counts.forwarded > 5)
    assert not list(traffic.look(time.monotonic()))
    ip("route", "del", "224.0.0.0/4", "dev", "lo")
    send_until(sender, lambda: sender.counts.failed > 5)
    before = sender.counts
    told = list(traffic.look(time.monotonic()))
    assert told == ["motors: the network takes no messages on the motor channels: nothing is sent"]
    assert traffic.fault == "the network takes no messages: nothing is sent"
    assert not list(traffic.look(time.monotonic()))
    sender.stop()
    until_s = time.monotonic() + 30.0
    while sender.counts.failed < before.failed + 20:
        assert time.monotonic() < until_s, sender.counts
        time.sleep(0.01)
    assert sender.stops == before.stops
    ip("route", "add", "224.0.0.0/4", "dev", "lo")
    send_until(sender, lambda: sender.counts.forwarded > before.forwarded + 5)
    assert sender.alive
    list(traffic.look(time.monotonic()))
    list(traffic.look(time.monotonic() + 2.0))
    assert not traffic.fault
    sender.close()
    assert sender.stops > 10


if __name__ == "__main__":
    main()
