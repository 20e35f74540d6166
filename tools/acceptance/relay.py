"""A relay between two LCM groups that can be told, line by line on its standard input, what to do to the camera.

Robot and navigation each have a group of their own; all crosses here, so that a fault of the camera, its edge or its
clock is one line of JSON: ``{"delay_s": 0.15}``, ``{"drop": "half"}``, ``{"silent": true}``, ``{"repeat": true}``,
``{"jump_s": 3600}``, ``{"picture": "white"}``, ``{"picture": "covered"}``; ``{}`` is no fault. Each line replaces the
one before. It imports nothing of the runner: what it tests is not what it is made of.
"""

from __future__ import annotations

import argparse
import heapq
import json
import sys
import threading
import time
from typing import Any

import lcm
import numpy as np

from graphnav import Image
from graphnav.codec import decode, encode

CAMERA = "CAMERA"
FORTH = (CAMERA, "ODOMETRY", "BEACON")
BACK = ("BASE_CMD",)
_MAX_WAIT_S = 0.002


class Relay:
    """Carries messages from one group to the other, the camera's with the fault that was asked for."""

    def __init__(self, robot_url: str, graph_url: str) -> None:
        self.fault: dict[str, Any] = {}
        self._robot, self._graph = lcm.LCM(robot_url), lcm.LCM(graph_url)
        self._waiting: list[tuple[float, int, str, bytes]] = []
        self._count = self._images = 0
        self._last: bytes | None = None
        self._lock = threading.Lock()
        for channel in FORTH:
            self._robot.subscribe(channel, self._forth).set_queue_capacity(0)
        for channel in BACK:
            self._graph.subscribe(channel, self._robot.publish).set_queue_capacity(0)

    def run(self) -> None:
        """Carry for ever."""
        threading.Thread(target=self._carry_back, daemon=True).start()
        threading.Thread(target=self._send_when_due, daemon=True).start()
        while True:
            self._robot.handle()

    def _carry_back(self) -> None:
        while True:
            self._graph.handle()

    def _forth(self, channel: str, data: bytes) -> None:
        delay_s = 0.0
        if channel == CAMERA:
            delay_s = float(self.fault.get("delay_s", 0.0))
            faulty = self._faulty(data)
            if faulty is None:
                return
            data = faulty
        with self._lock:
            self._count += 1
            heapq.heappush(self._waiting, (time.monotonic() + delay_s, self._count, channel, data))
        self._flush()

    def _faulty(self, data: bytes) -> bytes | None:
        """Return a picture as the fault makes it, None where it is lost."""
        self._images += 1
        fault = self.fault
        if fault.get("silent") or (fault.get("drop") == "half" and self._images % 2):
            return None
        if fault.get("repeat") and self._last is not None:
            return self._last
        if jump_s := fault.get("jump_s"):
            utime = int.from_bytes(data[8:16], "big", signed=True) + round(jump_s * 1e6)
            data = data[:8] + utime.to_bytes(8, "big", signed=True) + data[16:]
        if picture := fault.get("picture"):
            utime, seq, image = decode(Image, data)
            level = {"white": 255, "covered": 4}[picture]
            noise = np.random.default_rng(self._images).normal(0.0, 1.0, image.pixels.shape)
            pixels = np.clip(level + noise, 0, 255).astype(np.uint8)
            data = encode(Image(pixels=pixels, step_px=image.step_px), utime, seq)
        self._last = data
        return data

    def _send_when_due(self) -> None:
        while True:
            self._flush()
            time.sleep(_MAX_WAIT_S)

    def _flush(self) -> None:
        with self._lock:
            while self._waiting and self._waiting[0][0] <= time.monotonic():
                _, _, channel, data = heapq.heappop(self._waiting)
                self._graph.publish(channel, data)


def main() -> None:
    """Relay until standard input closes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robot_url")
    parser.add_argument("graph_url")
    args = parser.parse_args()
    relay = Relay(args.robot_url, args.graph_url)
    threading.Thread(target=relay.run, daemon=True).start()
    for line in sys.stdin:
        relay.fault = json.loads(line)


if __name__ == "__main__":
    main()
