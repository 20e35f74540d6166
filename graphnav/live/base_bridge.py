"""Pass the commands of a channel on to a base on a serial line, and stops when there are none."""

from __future__ import annotations

import math
import select
import time
from collections.abc import Callable

from graphnav import GraphnavError, Odometry, Twist
from graphnav.core.bus import Bus
from graphnav.core.codec import decode, encode
from graphnav.live.base_lines import CommandLine, OdometryLines
from graphnav.live.serial_line import SerialLine

STOP_PERIOD_S = 0.1
"""Between two stops while no command comes."""
RETRY_S = 0.5
"""Between two attempts to open a line that is gone."""
LAST_STOPS = 3
_LEAVE_S = 0.2
"""How long the last stops are given to leave."""
_TURN_S = 0.05


class BaseBridge:
    """Writes each command of a channel as a line, the newest one only; stops while none has come for ``timeout_s``.

    It writes when the line before has left, so that a slow line never delays a command behind older ones. A line that
    is gone is opened again: it begins with a stop, and commands count from then on. If this process was suspended for
    longer than ``timeout_s``, what came meanwhile is not obeyed. ``odometry``: a channel, and what reads the lines of
    the base that are published there. ``show`` gets what changes, a line each.
    """

    def __init__(
        self,
        bus: Bus,
        channel: str,
        path: str,
        baud: int,
        line: CommandLine,
        timeout_s: float,
        odometry: tuple[str, OdometryLines] | None,
        show: Callable[[str], None],
    ) -> None:
        self._bus, self._path, self._baud, self._line, self._timeout_s = bus, path, baud, line, timeout_s
        self._odometry, self._show = odometry, show
        self._port: SerialLine | None = None
        self._retry_s = -math.inf
        self._why = ""
        self._newest: Twist | None = None
        self._heard_s = -math.inf
        self._written_s = -math.inf
        self._rest = b""
        """Of a line that was written in part."""
        self._is_driving = False
        self._turned_s = math.inf
        self._n_odometry = self._n_bad = 0
        bus.subscribe(channel, self._receive)

    def run(self) -> None:
        """Pass on until something raises, as Ctrl-C does; then write stops."""
        try:
            while True:
                self.turn(_TURN_S)
        finally:
            self.close()

    def turn(self, wait_s: float) -> None:
        """Wait for a message or for bytes of the base, and do what is due."""
        read = [self._bus.fileno(), *([] if self._port is None else [self._port.fileno()])]
        select.select(read, [], [], wait_s)
        now_s = time.monotonic()
        is_late = now_s - self._turned_s > self._timeout_s + _TURN_S
        self._turned_s = now_s
        self._bus.drain()
        if is_late:
            self._newest, self._heard_s = None, -math.inf
        try:
            if self._open(now_s):
                self._hear()
                self._write(now_s)
        except OSError as error:
            self._lose(error, now_s)

    def close(self) -> None:
        """Write stops, and close the line."""
        if self._port is None:
            return
        end_s = time.monotonic() + _LEAVE_S
        data = self._rest + LAST_STOPS * self._line.stop
        try:
            while time.monotonic() < end_s and (data or self._port.pending_bytes()):
                data = data[self._port.write(data) :] if data else data
                time.sleep(0.005)
        except OSError:
            pass
        self._port.close()
        self._port = None

    def _receive(self, _channel: str, data: bytes) -> None:
        try:
            twist = decode(Twist, data)[2]
            is_bad = bool(twist.not_finite())
        except GraphnavError:
            is_bad = True
        if is_bad:
            self._n_bad += 1
            if self._n_bad == 1:
                self._show("not used: a message that is not a twist of finite numbers")
            return
        self._newest, self._heard_s = twist, time.monotonic()

    def _open(self, now_s: float) -> bool:
        """Return whether the line is open, after an attempt to open it if one is due."""
        if self._port is not None:
            return True
        if now_s < self._retry_s:
            return False
        self._retry_s = now_s + RETRY_S
        self._port = SerialLine(self._path, self._baud)
        self._why = ""
        self._newest, self._heard_s, self._rest = None, -math.inf, b""
        self._written_s, self._is_driving = -math.inf, False
        self._show(f"open: {self._path} at {self._baud} baud; it gets stops until commands come")
        return True

    def _lose(self, error: OSError, now_s: float) -> None:
        if self._port is not None:
            self._port.close()
        self._port, self._retry_s = None, now_s + RETRY_S
        why = error.strerror or str(error)
        if why != self._why:
            self._show(f"lost: {self._path}: {why}; it is opened again as soon as that is possible")
            self._why = why

    def _hear(self) -> None:
        assert self._port is not None
        data = self._port.read()
        if not data or self._odometry is None:
            return
        channel, lines = self._odometry
        n_unread = lines.unread
        for found in lines.feed(data):
            self._publish(channel, found)
        if lines.unread and not n_unread:
            self._show("not used: a line of the base that does not fit --odometry")

    def _publish(self, channel: str, odometry: Odometry) -> None:
        self._bus.publish(channel, encode(odometry, time.time_ns() // 1000, self._n_odometry))
        self._n_odometry += 1

    def _write(self, now_s: float) -> None:
        """Write the newest command, or a stop, when the line before has left."""
        assert self._port is not None
        is_fresh = now_s - self._heard_s <= self._timeout_s
        if is_fresh != self._is_driving:
            self._is_driving = is_fresh
            self._newest, self._written_s = (self._newest, self._written_s) if is_fresh else (None, -math.inf)
            silent = f"silent: no command for {self._timeout_s:g} s; the base gets stops"
            self._show("driving: commands come" if is_fresh else silent)
        if self._port.pending_bytes():
            return
        data = self._rest
        if not data and self._newest is not None:
            data, self._newest = self._line.of(self._newest), None
        elif not data and not is_fresh and now_s - self._written_s >= STOP_PERIOD_S:
            data = self._line.stop
        if data:
            self._rest = data[self._port.write(data) :]
            self._written_s = now_s
