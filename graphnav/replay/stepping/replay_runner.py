"""Step stages by the ticks of a log; messages of other stages are played from it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from graphnav.bus import Bus
from graphnav.codec import decode
from graphnav.graph import Channel
from graphnav.messages import Message
from graphnav.record import Recording
from graphnav.replay.log.contents import Logged
from graphnav.replay.log.schedule import Tick
from graphnav.replay.plan import Plan
from graphnav.runner.owned_stages import Sink
from graphnav.runner.wired_stages import WiredStages
from graphnav.stage import Stage


class ReplayRunner(WiredStages):
    """Owns the stepping stages; fires them tick by tick of the log, in the firing order of the complete graph.

    ``before``: messages from before the first of the ``ticks``, for stages that sample their channels. ``sinks`` take
    the published messages, ``player_sinks`` the played ones.
    """

    def __init__(
        self,
        plan: Plan,
        stages: Mapping[str, Stage],
        bus: Bus,
        sinks: Sequence[Sink],
        recording: Recording,
        ticks: Sequence[Tick],
        before: Sequence[Logged] = (),
        player_sinks: Sequence[Sink] = (),
    ) -> None:
        super().__init__(plan.stepped, stages, bus, sinks)
        self._recording = recording
        self._to_come, self._before = ticks, before
        self._player_sinks = player_sinks
        self._played = {channel.name for channel in plan.played}
        self._messages = {channel.name: channel.message for channel in plan.played}
        outside = dict.fromkeys(channel.stage for channel in plan.played if channel.ref in plan.graph.inputs)
        self._firing_order = [*outside, *(node.name for node in (*plan.graph.sources, *plan.graph.order))]

    def close(self) -> None:
        """Close the stages and the bus.

        Raises
        ------
        StageError
            The first failure, after every stage was closed.
        """
        self._bus.close()
        super().close()

    def replay(self) -> Iterator[int]:
        """Process the ticks; yield the timestamp of each one, microseconds.

        Raises
        ------
        StageError
            A stage raised, or returned an invalid value.
        DecodeError
            A message of the log is damaged.
        """
        for message in self._before:
            self._prime(message)
        for tick in self._to_come:
            self._tick(tick)
            self.ticks += 1
            yield tick.utime

    def _tick(self, tick: Tick) -> None:
        """Play the messages of a tick and fire the stages whose plain inputs are then complete."""
        self.utime = tick.utime
        for name in self._firing_order:
            for message in tick.played.get(name, ()):
                self._play(message)
            if (unit := self._units.get(name)) is not None:
                self._fire_complete(unit, tick.utime)

    def _prime(self, message: Logged) -> None:
        """Deliver a message from before the first tick to stages that sample its channel; it fires no stage."""
        name = message.channel
        data = self._recording.event(name, message.place).data
        readers = [
            (u, i.port) for u in self._units.values() for i in u.node.inputs if i.channel and i.channel.name == name
        ]
        sampling = [(unit, port.name) for unit, port in readers if port.latest]
        if sampling and not any(port.is_plain for _, port in readers):
            for sink in self._player_sinks:
                sink.write(name, message.utime, data)
        utime, _, value = decode(self._messages[name], data)
        for unit, port_name in sampling:
            unit.deliver(port_name, utime, value)

    def _play(self, message: Logged) -> None:
        name = message.channel
        if name not in self._consumed and not self._player_sinks:
            return
        data = self._recording.event(name, message.place).data
        for sink in self._player_sinks:
            sink.write(name, message.utime, data)
        if name in self._consumed:
            self._bus.publish(name, data)
            self._bus.drain()

    def _publish(self, channel: Channel, utime: int, message: Message) -> None:
        """Publish the output of a stage, unless the channel is played."""
        if channel.name not in self._played:
            super()._publish(channel, utime, message)
