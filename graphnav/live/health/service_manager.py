"""Tell the program that keeps a live run running: that it is ready, that its engine turns, that it ends."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, MutableMapping

_TURNS = 4
"""So often a turning engine is told within the time after which it counts as hung."""


class ServiceManager:
    """The socket of systemd, or of another program that speaks its protocol, or none.

    It is told ``READY=1`` once the stages, inputs and motors of a run are ready, ``WATCHDOG=1`` while the engine turns,
    what is faulty, and ``STOPPING=1`` when the run ends. If it cannot be told, ``notice`` gets that, once, and the run
    goes on. Its variables are removed from ``environment``, so that no child speaks for the run.

    Source: sd_notify(3), sd_watchdog_enabled(3).
    """

    def __init__(self, notice: Callable[[str], None], environment: MutableMapping[str, str] = os.environ) -> None:
        address = environment.pop("NOTIFY_SOCKET", "")
        watched_pid, period_us = environment.pop("WATCHDOG_PID", ""), environment.pop("WATCHDOG_USEC", "")
        is_watched = period_us.isdecimal() and int(period_us) > 0 and watched_pid in ("", str(os.getpid()))
        self._period_s = int(period_us) / 1e6 / _TURNS if is_watched else None
        self._due_s = 0.0
        self._notice, self._is_failing_told = notice, False
        self._address = f"\0{address[1:]}" if address.startswith("@") else address

    def tell_ready(self) -> None:
        """Tell that everything of the run is ready."""
        self._tell("READY=1")

    def tell_turn(self) -> None:
        """Tell that the engine turns, if that is due."""
        if self._period_s is not None and (now_s := time.monotonic()) >= self._due_s:
            self._due_s = now_s + self._period_s
            self._tell("WATCHDOG=1")

    def tell_status(self, line: str) -> None:
        """Tell how the run is."""
        self._tell(f"STATUS={' '.join(line.split())}")

    def tell_end(self) -> None:
        """Tell that the run ends, which is the last that it tells."""
        self._tell("STOPPING=1")
        self._address = ""

    def _tell(self, line: str) -> None:
        if not self._address:
            return
        try:
            with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK) as link:
                link.sendto(line.encode(), self._address)
        except BlockingIOError:
            pass  # it is behind with reading; the next one will do
        except OSError as error:
            if self._is_failing_told:
                return
            self._is_failing_told = True
            self._notice(
                f"NOTIFY_SOCKET: what waits for this run cannot be told of it: {error.strerror or error}\n"
                "  start it by systemd with Type=notify, or without NOTIFY_SOCKET"
            )
