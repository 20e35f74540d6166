"""Receive the pictures of a device in a thread, which keeps the newest one."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from graphnav import ParamError
from graphnav.arrays import Bytes
from graphnav_io.capture import interruptible
from graphnav_io.device import Device, OpenDevice, Wanted, open_device
from graphnav_io.driver_clock import DriverClock
from graphnav_io.quiet import quiet_beside

RETRY_S = 1.0
"""Between two attempts to open a device that is gone."""
MAX_DAMAGED = 30
"""So many pictures in a row that cannot be decoded: the device is opened again."""
MAX_TOLD = 100
_MARGIN_S = 1.0
"""Beyond the timeout of OpenCV, which tells more."""
_CLOSE_S = 0.5
"""How long the thread is waited for at the end; one that waits for its device ends with the process."""


class Picture(NamedTuple):
    """A picture, and when it was taken, monotonic seconds."""

    pixels: Bytes
    taken_s: float


class PictureReceiver:
    """Receives pictures from a device until it is closed; opens it again when it is gone.

    ``wake`` is called, in the thread, for each picture and at the end. ``replaced`` counts pictures that a newer one
    replaced before they were taken, ``reopened`` how often the device was opened again.
    """

    def __init__(self, device: Device, wanted: Wanted, wake: Callable[[], None]) -> None:
        self.replaced = self.reopened = 0
        self._device, self._wanted, self._wake = device, wanted, wake
        self._newest: Picture | None = None
        self.ended_s: float | None = None
        """When a recording had no picture left, monotonic seconds; the newest one may still be there."""
        self._told: deque[str] = deque(maxlen=MAX_TOLD)
        self._changing = threading.Lock()
        self._ending = threading.Event()
        self._clock = DriverClock()
        self._shape: tuple[int, ...] | None = None
        """Of the pictures that were told of last."""
        try:
            opened = interruptible(self._opened, wanted.timeout_s + _MARGIN_S)
        except TimeoutError:
            what = f"{device.name} was not open after {wanted.timeout_s:g} s"
            raise ParamError("device", what, "start what writes to it, or set 'timeout_s'") from None
        self._thread = threading.Thread(target=self._serve, args=(opened,), name="graphnav-camera", daemon=True)
        self._thread.start()

    def take(self) -> Picture | None:
        """Take the newest picture, None if there is none since the last one."""
        with self._changing:
            newest, self._newest = self._newest, None
        return newest

    def told(self) -> list[str]:
        """Return what became of the device since the last call."""
        return [self._told.popleft() for _ in range(len(self._told))]

    def close(self) -> None:
        """End; the thread releases the device."""
        self._ending.set()
        self._thread.join(_CLOSE_S)

    def _opened(self) -> OpenDevice:
        quiet_beside()
        return open_device(self._device, self._wanted)

    def _serve(self, opened: OpenDevice | None) -> None:
        quiet_beside()
        while not self._ending.is_set():
            if opened is None:
                opened = self._reopened()
                continue
            try:
                why = self._receive(opened)
            finally:
                opened.close()
            opened = None
            if self._ending.is_set():
                return
            if self._device.is_played:
                self._told.append(f"ended: {why}")
                self.ended_s = self._clock.taken_s(0.0, time.monotonic())
                self._wake()
                return
            self._told.append(f"lost: {why}; it is opened again as soon as that is possible")

    def _reopened(self) -> OpenDevice | None:
        """Return the device, if it can be opened again; wait a little before."""
        if self._ending.wait(RETRY_S):
            return None
        try:
            opened = self._opened()
        except ParamError:
            return None
        self.reopened += 1
        self._shape = None  # tell what it is now
        self._clock.begin()
        return opened

    def _receive(self, opened: OpenDevice) -> str:
        """Receive until the device gives no picture; return why."""
        count = damaged = 0
        begin_s = time.monotonic()
        while not self._ending.is_set():
            if self._device.is_played and self._ending.wait(begin_s + count / opened.rate_hz - time.monotonic()):
                break
            try:
                found = opened.read()
            except ValueError as error:
                damaged += 1
                if self._device.is_played or damaged >= MAX_DAMAGED:
                    return str(error)
                continue
            if found is None:
                return f"{self._device.name} has no picture left" if self._device.is_played else self._gone(count)
            pixels, driver_s = found
            damaged = 0
            if self._clock.is_repeated(driver_s):
                continue
            count += 1
            self._put(Picture(pixels, self._clock.taken_s(driver_s, time.monotonic())), opened)
        return ""

    def _gone(self, count: int) -> str:
        return f"{self._device.name} gives no picture any more" if count else f"{self._device.name} gave no picture"

    def _put(self, picture: Picture, opened: OpenDevice) -> None:
        if picture.pixels.shape != self._shape:
            self._shape = picture.pixels.shape
            self._told.append(self._described(opened))
            self._told.extend(opened.told)
        with self._changing:
            self.replaced += self._newest is not None
            self._newest = picture
        self._wake()

    def _described(self, opened: OpenDevice) -> str:
        """Return what the device gives, for the user."""
        assert self._shape is not None
        rows, cols = self._shape[:2]
        rate = f" at {opened.rate_hz:g} Hz" if opened.rate_hz else ""
        wanted = self._wanted.size
        other = f", not {wanted[0]}x{wanted[1]} as asked," if wanted not in (None, (cols, rows)) else ""
        return f"{self._device.name} gives {cols}x{rows}{other}{rate}; pictures are stamped by {self._clock.kind}"
