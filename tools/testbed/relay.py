"""A relay between two LCM groups that can be told, line by line on its standard input, what to do to the camera.

Robot and navigation each have a group of their own, and relays carry the channels named from one to the other, so that
a fault of the camera, its edge or its clock is one line of JSON: ``{"delay_s": 0.15}``, ``{"jitter_s": 0.03}``,
``{"drop": "half"}``, ``{"silent": true}``, ``{"repeat": true}``, ``{"jump_s": 3600}``, ``{"stamps": "milliseconds"}``
(see `STAMPS`), ``{"picture": KIND}`` (white, covered: dark, cloth: texture on the lens), ``{"freeze_gray": 1.0}`` (the
last picture under new stamps, with noise of so many gray levels); of odometry ``{"odometry": KIND}`` (see `ODOMETRY`),
``{"spin": true}`` (it moves as the base is told), ``{"hold": true}`` (the last pose under new stamps); of commands
``{"stand": true}`` (the base stands); ``{}`` means no fault. Each line replaces the one before. ``{"corrupt": KIND}``
corrupts every second message of the first channel, whichever it is.
It imports nothing of the runner: what it tests is not what it is made of.
"""

from __future__ import annotations

import argparse
import heapq
import json
import math
import random
import sys
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import lcm
import numpy as np

from graphnav import Image, Odometry, Twist
from graphnav.arrays import Doubles
from graphnav.core.codec import decode, encode
from testbed.corrupt import Corrupter

CAMERA, ODOMETRY_CHANNEL, COMMANDS = "CAMERA", "ODOMETRY", "BASE_CMD"
STAMPS: dict[str, Callable[[int], int]] = {
    "seconds": lambda utime: utime // 1_000_000,
    "milliseconds": lambda utime: utime // 1000,
    "nanoseconds": lambda utime: utime * 1000,
    "CLOCK_MONOTONIC": lambda utime: utime + (time.monotonic_ns() - time.time_ns()) // 1000,
    "zero": lambda _: 0,
}
"""Stamps in another unit or of another clock."""
ODOMETRY: dict[str, Callable[[Odometry], Odometry]] = {
    "jump": lambda o: replace(o, x_m=o.x_m + 100.0),
    "zero": lambda o: replace(o, x_m=0.0, y_m=0.0, yaw_rad=0.0, v_mps=0.0, omega_radps=0.0),
    "reversed": lambda o: replace(o, yaw_rad=-o.yaw_rad, omega_radps=-o.omega_radps),
    "degrees": lambda o: replace(o, yaw_rad=math.degrees(o.yaw_rad), omega_radps=math.degrees(o.omega_radps)),
}
"""Wrong odometry."""
_LEVEL = {"white": 255, "covered": 4}
_CLOTH_PX = 12
"""Size of the squares of the texture that covers the lens."""


class SpinningWheels:
    """Odometry of a base whose wheels turn as they are told, whether it moves or not."""

    def __init__(self, url: str) -> None:
        self._lcm = lcm.LCM(url)
        self._lcm.subscribe(COMMANDS, self._hear)
        self._told = Twist(v_mps=0.0, omega_radps=0.0)
        self._last: tuple[int, Odometry] | None = None
        threading.Thread(target=self._listen, daemon=True).start()

    def odometry(self, utime: int, honest: Odometry) -> Odometry:
        """Return what the wheels measure; ``honest`` is where they begin."""
        before, last = self._last or (utime, honest)
        s, v, w = (utime - before) * 1e-6, self._told.v_mps, self._told.omega_radps
        x_m, y_m = last.x_m + v * s * math.cos(last.yaw_rad), last.y_m + v * s * math.sin(last.yaw_rad)
        found = Odometry(x_m=x_m, y_m=y_m, yaw_rad=last.yaw_rad + w * s, v_mps=v, omega_radps=w)
        self._last = utime, found
        return found

    def _hear(self, _channel: str, data: bytes) -> None:
        self._told = decode(Twist, data)[2]

    def _listen(self) -> None:
        while True:
            self._lcm.handle()


class Relay:
    """Carries messages from one group to another, the camera's with the fault that was asked for."""

    def __init__(self, source_url: str, target_url: str, channels: Sequence[str]) -> None:
        self.fault: dict[str, Any] = {}
        self._source, self._target = lcm.LCM(source_url), lcm.LCM(target_url)
        self._first = channels[0]
        self._corrupter = Corrupter(channels[0])
        self._waiting: list[tuple[float, int, str, bytes]] = []
        self._count = self._images = 0
        self._random = random.Random(1)
        self._wheels = SpinningWheels(target_url) if ODOMETRY_CHANNEL in channels else None
        self._last: bytes | None = None
        self._pose: Odometry | None = None
        self._condition = threading.Condition()
        for channel in channels:
            self._source.subscribe(channel, self._hear).set_queue_capacity(0)

    def run(self) -> None:
        """Carry for ever."""
        threading.Thread(target=self._send_when_due, daemon=True).start()
        while True:
            self._source.handle()

    def _hear(self, channel: str, data: bytes) -> None:
        delay_s = 0.0
        if (kind := self.fault.get("corrupt")) and channel == self._first:
            data = self._corrupter.spoil(kind, data)
        elif channel == ODOMETRY_CHANNEL:
            data = self._faulty_odometry(data)
        elif channel == COMMANDS and self.fault.get("stand"):
            utime, seq, _ = decode(Twist, data)
            data = encode(Twist(v_mps=0.0, omega_radps=0.0), utime, seq)
        elif channel == CAMERA:
            delay_s = float(self.fault.get("delay_s", 0.0))
            delay_s += self._random.uniform(0.0, float(self.fault.get("jitter_s", 0.0)))
            faulty = self._faulty(data)
            if faulty is None:
                return
            data = faulty
        if delay_s == 0.0:
            self._target.publish(channel, data)
            return
        with self._condition:
            self._count += 1
            heapq.heappush(self._waiting, (time.monotonic() + delay_s, self._count, channel, data))
            self._condition.notify()

    def _faulty_odometry(self, data: bytes) -> bytes:
        utime, seq, odometry = decode(Odometry, data)
        if wrong := self.fault.get("odometry"):
            return encode(ODOMETRY[wrong](odometry), utime, seq)
        if self.fault.get("spin") and self._wheels is not None:
            return encode(self._wheels.odometry(utime, odometry), utime, seq)
        if self.fault.get("hold"):
            return encode(replace(self._pose or odometry, v_mps=0.0, omega_radps=0.0), utime, seq)
        self._pose = odometry
        return data

    def _faulty(self, data: bytes) -> bytes | None:
        """Return a picture as the fault makes it, None where it is lost."""
        self._images += 1
        fault = self.fault
        if fault.get("silent") or (fault.get("drop") == "half" and self._images % 2):
            return None
        if fault.get("repeat") and self._last is not None:
            return self._last
        if fault.keys() & {"jump_s", "stamps"}:
            utime = int.from_bytes(data[8:16], "big", signed=True) + round(fault.get("jump_s", 0.0) * 1e6)
            utime = STAMPS[fault["stamps"]](utime) if "stamps" in fault else utime
            data = data[:8] + utime.to_bytes(8, "big", signed=True) + data[16:]
        if picture := fault.get("picture"):
            utime, seq, image = decode(Image, data)
            noise = np.random.default_rng(self._images).normal(0.0, 1.0, image.pixels.shape)
            level = _cloth(image.pixels.shape) if picture == "cloth" else _LEVEL[picture]
            pixels = np.clip(level + noise, 0, 255).astype(np.uint8)
            data = encode(Image(pixels=pixels, step_px=image.step_px), utime, seq)
        if (noise_gray := fault.get("freeze_gray")) is not None and self._last is not None:
            utime, seq, _ = decode(Image, data)
            _, _, image = decode(Image, self._last)
            noise = np.random.default_rng(self._images).normal(0.0, noise_gray, image.pixels.shape)
            pixels = np.clip(image.pixels + noise + 0.5, 0, 255).astype(np.uint8)
            return encode(Image(pixels=pixels, step_px=image.step_px), utime, seq)
        self._last = data
        return data

    def _send_when_due(self) -> None:
        while True:
            with self._condition:
                while not self._waiting:
                    self._condition.wait()
                wait_s = self._waiting[0][0] - time.monotonic()
                if wait_s > 0:
                    self._condition.wait(wait_s)
                    continue
                _, _, channel, data = heapq.heappop(self._waiting)
            self._target.publish(channel, data)


def _cloth(shape: tuple[int, ...]) -> Doubles:
    rows, cols = shape[:2]
    squares = np.random.default_rng(0).uniform(60.0, 180.0, (rows // _CLOTH_PX + 1, cols // _CLOTH_PX + 1))
    texture = squares.repeat(_CLOTH_PX, 0).repeat(_CLOTH_PX, 1)[:rows, :cols]
    return texture.reshape(rows, cols, *[1] * (len(shape) - 2))


def main() -> None:
    """Relay until standard input closes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("source_url")
    parser.add_argument("target_url")
    parser.add_argument("channels", nargs="+")
    args = parser.parse_args()
    relay = Relay(args.source_url, args.target_url, args.channels)
    threading.Thread(target=relay.run, daemon=True).start()
    for line in sys.stdin:
        relay.fault = json.loads(line)


if __name__ == "__main__":
    main()
