"""Step sources again by the recorded messages of their inputs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from graphnav import Recording, Stage
from graphnav.core.codec import decode
from graphnav.core.graph import Channel
from graphnav.core.runner import LockstepEngine
from graphnav.replay.log.contents import Contents
from graphnav.replay.log.reproduction import Reproduction


class Made(NamedTuple):
    """A message that a source has made again."""

    channel: Channel
    utime: int
    seq: int
    data: bytes


class ReproducedSources:
    """Fires the sources of a `Reproduction`, by the clock as in the run, with the seed of the run.

    They hear recorded messages only: what other stages of a replay publish changes nothing.
    """

    def __init__(
        self, reproduction: Reproduction, stages: Mapping[str, Stage], recording: Recording, contents: Contents
    ) -> None:
        self.engine = LockstepEngine(reproduction.nodes, stages, (), is_wired=False, published=self._keep)
        self._reproduction, self._recording = reproduction, recording
        self._messages = {channel.name: channel.message for channel in reproduction.inputs}
        self._heard = {node.name: reproduction.heard_by(node, contents) for node in reproduction.nodes}
        self._n_heard = dict.fromkeys(self._heard, 0)
        self._due = dict.fromkeys(self._heard, (0, 0))
        """The stamp at which each source is due, and the number of the firing."""
        self._made: list[Made] = []

    def reset(self) -> None:
        """Reset the sources by the seed of the run.

        Raises
        ------
        StageError
            One cannot be reset.
        """
        self.engine.reset(self._reproduction.seed)
        self._n_heard = dict.fromkeys(self._heard, 0)
        self._due = dict.fromkeys(self._heard, (0, 0))

    def next_due(self) -> int:
        """Return the stamp at which the next source is due, microseconds."""
        return min(stamp for stamp, _ in self._due.values())

    def fire(self, name: str, utime: int) -> list[Made]:
        """Step a source if it is due; return what it publishes, nothing if it is not a source that is stepped again.

        Raises
        ------
        StageError
            It raised, or returned something invalid.
        DecodeError
            A message that it samples is damaged.
        """
        stamp, k = self._due.get(name, (-1, 0))
        if stamp != utime:
            return []
        unit = self.engine.units[name]
        self._hear(name, utime)
        self.engine.utime, self._made = utime, []
        self.engine.fire_at(unit, utime)
        self._due[name] = unit.due_us(k + 1), k + 1
        return self._made

    def _hear(self, name: str, utime: int) -> None:
        unit, heard = self.engine.units[name], self._heard[name]
        while (n := self._n_heard[name]) < len(heard) and (heard[n].utime, not heard[n].is_before) <= (
            utime,
            False,
        ):
            channel, place = heard[n].message.channel, heard[n].message.place
            sent, _, message = decode(self._messages[channel], self._recording.event(channel, place).data)
            for i in unit.node.inputs:
                if i.channel is not None and i.channel.name == channel:
                    unit.inbox.put(i.port, sent, 0, message)
            self._n_heard[name] = n + 1

    def _keep(self, channel: Channel, utime: int, number: int, _message: object, data: bytes) -> None:
        self._made.append(Made(channel, utime, number, data))
