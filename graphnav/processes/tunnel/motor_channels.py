"""The motor channels of a group, as far as they can be known: they pass only where they are named."""

from __future__ import annotations

import time
from collections.abc import Collection
from typing import NamedTuple

from graphnav import About, GraphnavError, Stop, Twist
from graphnav.core.codec import codec_of, decode
from graphnav.core.spec import outline_of

_MAX_RUNS = 32
_LEARNS_S = 0.2
"""Announcements are read at most so often: any program can send them."""
_ENVELOPE_BYTES = 24


class _Run(NamedTuple):
    """An announced run: the bytes of what announced it, the channels that it sends to motors, listens to, and has."""

    body: bytes
    motor: Collection[str]
    inputs: Collection[str]
    channels: Collection[str]


class MotorChannels:
    """The channels of a group that move a robot, or let it move.

    They are those that runs announce as motor outputs, and any with a twist or a stop: a base, a graph or a guard may
    listen to it. Those that a run merely taps, under the names of its stages, are not. What moves by another type is
    known only while a run announces it. The newest 32 runs are kept.
    """

    def __init__(self) -> None:
        self._moving = {codec_of(kind.lcm_class).fingerprint for kind in (Twist, Stop)}
        self._runs: dict[str, _Run] = {}
        self._motor: set[str] = set()
        self._tapped: set[str] = set()
        self._due_s = 0.0

    def learn(self, data: bytes) -> None:
        """Read an announcement of a run; what is not one changes nothing."""
        now_s = time.monotonic()
        body = data[_ENVELOPE_BYTES:]
        if now_s < self._due_s or any(body == run.body for run in self._runs.values()):
            return
        self._due_s = now_s + _LEARNS_S
        try:
            about = decode(About, data)[2]
            spec = outline_of(about.graph_yaml.encode(), About.CHANNEL)
        except GraphnavError:
            return
        motor = {str(one.channel.value.data) for one in spec.outputs.values() if one.motor and one.channel}
        inputs = {one.channel_name for one in spec.inputs.values()}
        self._runs.pop(about.run_id, None)
        self._runs[about.run_id] = _Run(body, motor, inputs, frozenset(about.channels))
        while len(self._runs) > _MAX_RUNS:
            del self._runs[next(iter(self._runs))]
        runs = self._runs.values()
        self._motor = set[str]().union(*(run.motor for run in runs))
        self._tapped = set[str]().union(*(run.channels for run in runs)).difference(*(run.inputs for run in runs))

    def has(self, channel: str, data: bytes) -> bool:
        """Whether a message is on a motor channel."""
        return channel in self._motor or (data[:8] in self._moving and channel not in self._tapped)

    def is_announced(self, channel: str) -> bool:
        """Whether a run announces a channel as a motor output."""
        return channel in self._motor
