"""Publish one message repeatedly, stamped and numbered."""

from __future__ import annotations

import time
from collections.abc import Callable

from graphnav.core.bus import Bus
from graphnav.core.codec import codec_of, fields_of
from graphnav.live.publish.fields import Fields

_SAME_S = 1e-6
"""Times closer than this are equal: multiples of a period are not exact."""


class Publisher:
    """Publishes a message on a channel.

    If its type has ``utime`` and ``seq`` and they are not given, ``utime`` is the time of day in microseconds and
    ``seq`` counts from 0. ``count``: number of messages published.
    """

    def __init__(
        self, bus: Bus, channel: str, lcm_class: type, fields: Fields, now_ns: Callable[[], int] = time.time_ns
    ) -> None:
        self.count = 0
        self._bus, self._channel, self._now_ns = bus, channel, now_ns
        self._codec, self._values = codec_of(lcm_class), dict(fields.values)
        stamps = {field.name for field in fields_of(lcm_class) if field.primitive == "int64_t" and not field.dims}
        self._filled = ({"utime", "seq"} & stamps) - fields.given

    def publish(self) -> None:
        """Send the next message; raises BusError if the network refuses it."""
        if "utime" in self._filled:
            self._values["utime"] = self._now_ns() // 1000
        if "seq" in self._filled:
            self._values["seq"] = self.count
        self._bus.send(self._channel, self._codec.encode(self._values))
        self.count += 1


def repeat(
    publish: Callable[[], None],
    rate_hz: float,
    n: int | None = None,
    for_s: float | None = None,
    now_s: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> None:
    """Call ``publish`` at a rate, ``n`` times, for ``for_s`` seconds, or until something raises.

    A late call delays the following ones: missed calls are not made up for.
    """
    begin_s = due_s = now_s()
    count = 0
    while n is None or count < n:
        if for_s is not None and due_s - begin_s > for_s - _SAME_S:
            return
        if (wait_s := due_s - now_s()) > 0:
            sleep(wait_s)
        publish()
        count += 1
        due_s = max(due_s + 1 / rate_hz, now_s())
