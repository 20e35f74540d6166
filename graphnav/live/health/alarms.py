"""Alarms of a live run: late and lost messages, silent inputs, other programs on the motor channels."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator

from graphnav.core.bus import Bus
from graphnav.core.codec import codec_of
from graphnav.core.dds import Ros2Node
from graphnav.core.errors import shown_name
from graphnav.core.graph import InputChannel
from graphnav.core.large_messages import PACKET_BYTES
from graphnav.core.machine import ReceiveBuffer
from graphnav.core.ros2 import LOOPBACK
from graphnav.core.runner import size_text
from graphnav.live.health.clocks import Clocks
from graphnav.live.health.motor_traffic import MotorTraffic
from graphnav.live.inputs.intake import Intake
from graphnav.live.inputs.receiver import SCAN_S, Receiver, TypeScan
from graphnav.live.live_schedule import LiveSchedule
from graphnav.live.outlet import Outlet

_MIN_OVERTAKEN = 3
"""Fewer overtaken messages per second are counted, but not reported."""
_MIN_BUSY_RATIO = 0.5
"""A stage that took less of the last second is not why messages were overtaken."""
_MIN_LOST = 3
"""Fewer lost messages are counted, but not reported."""
_MIN_FOREIGN = 5
"""A larger excess of messages on a motor channel comes from another program, not from counting at two times."""
_MIN_REFUSED = 3
"""Fewer refused commands are counted, but not reported."""
_SILENT_S = 2.0
_MAX_NAMED = 3


class Alarms:
    """Yields notices, once a second; each problem is reported at first, and again when its count has doubled.

    ``traffic`` counts the messages on the motor channels.
    """

    def __init__(self, schedule: LiveSchedule, traffic: MotorTraffic, clocks: Clocks) -> None:
        self._schedule, self._traffic, self._clocks = schedule, traffic, clocks
        self._told: dict[str, int] = {}
        self._overtaken: Counter[str] = Counter()
        self._busy_s: dict[str, float] = {}
        self._away = set[str]()
        self._restarts: dict[str, int] = {}
        self._asked_s = schedule.clock.now_s()
        self._scan: TypeScan | None = None

    def close(self) -> None:
        """Stop listening for channels of silent inputs' types."""
        if self._scan is not None:
            self._scan.close()

    def look(self, receiver: Receiver | None, topics: Ros2Node | None) -> Iterator[str]:
        """Yield the alarms since the last call; ``receiver``, ``topics``: what listens, None before it does."""
        now_s = self._schedule.clock.now_s()
        elapsed_s, self._asked_s = max(now_s - self._asked_s, 1e-6), now_s
        yield from self._clocks.look()
        yield from self._late(elapsed_s)
        for intake in self._schedule.intakes.values():
            yield from self._silent(intake, now_s, receiver, topics)
            yield from self._lost(intake)
        yield from self.of_sources()
        for timer, unit in self._schedule.live_sources:
            silent_s, what = now_s - timer.heard_s, f"{unit.node.name} silent"
            if silent_s <= _SILENT_S:
                self._told.pop(what, None)
            elif self._is_news(what, round(silent_s), 1):
                yield f"silent: {unit.node.name} has had nothing from its device for {silent_s:.0f} s"
        if receiver is not None:
            yield from self._dropped(receiver)
        for outlet in self._schedule.outlets.values():
            ref, channel = outlet.target.channel.ref, outlet.target.name
            if topics is not None and outlet.target.ros_type is not None:
                yield from self._unheard(outlet, now_s, topics)
            if self._is_news(f"{ref} refused", outlet.refused, _MIN_REFUSED):
                taker = "by LCM" if outlet.target.ros_type is None else "by DDS"
                taker = "by the process that sends the motor channels" if outlet.target.motor else taker
                yield f"not sent: {outlet.refused} messages of {ref} on {channel} were not taken {taker}"
            if self._is_news(f"{ref} overtaken", outlet.overtaken, 1):
                yield f"not sent: {outlet.overtaken} messages of {ref} on {channel}: newer ones were pending"
        late = self._traffic.late
        if self._is_news("motors late", late, _MIN_REFUSED):
            yield f"not sent: {late} commands were older than max_age_s before the motor process had read them"
        heard, sent = self._traffic.counts()
        if self._is_news("foreign", heard - sent, _MIN_FOREIGN):
            channels = ", ".join(
                outlet.target.name for outlet in self._schedule.outlets.values() if outlet.target.motor
            )
            yield (
                f"another program also sends on {channels}: {heard - sent} of {heard} messages are not from this run\n"
                "  end one of them: the motors get the commands of both"
            )

    def of_sources(self) -> Iterator[str]:
        """Yield what sources tell of their devices."""
        for _, unit in self._schedule.live_sources:
            for line in unit.notices():
                yield f"{unit.node.name}: {line}"

    def _late(self, elapsed_s: float) -> Iterator[str]:
        """Yield edges with overtaken messages and the slowest stage, and missed deadlines."""
        units = self._schedule.engine.units
        were_away, self._away = self._away, {name for name in units if self._schedule.is_away(name)}
        restarts, self._restarts = self._restarts, {name: unit.restarts for name, unit in units.items()}
        busy_s = {name: unit.durations.total_s for name, unit in units.items()}
        spent_s = {name: total_s - self._busy_s.get(name, 0.0) for name, total_s in busy_s.items()}
        self._busy_s = busy_s
        slowest = max(spent_s, key=lambda name: spent_s[name])
        step_ms = units[slowest].durations.quantile_s(0.5) * 1e3
        for edge, count in self._schedule.overtaken().items():
            grown, self._overtaken[edge] = count - self._overtaken[edge], count
            if grown < _MIN_OVERTAKEN or self._clocks.is_troubled or not self._is_news(edge, count, 1):
                continue
            reader = edge.partition(".")[0]
            if reader in were_away | self._away or self._restarts[reader] > restarts.get(reader, 0):
                yield f"overtaken: {count} messages on {edge}: the process of {reader} was started again"
            elif (share := min(1.0, spent_s[slowest] / elapsed_s)) >= _MIN_BUSY_RATIO:
                yield (
                    f"late: {count} messages overtaken on {edge}; {slowest} took {share:.0%} of the last second, "
                    f"{step_ms:.0f} ms a step"
                )
            else:
                yield f"overtaken: {count} messages on {edge} came in bursts or had no partner: no stage was busy"
        for name, unit in units.items():
            if self._is_news(f"{name} missed", unit.missed, 1):
                yield f"late: {name} missed its deadline of {unit.node.deadline_ms:g} ms {unit.missed} times"

    def _silent(
        self, intake: Intake, now_s: float, receiver: Receiver | None, topics: Ros2Node | None
    ) -> Iterator[str]:
        """Yield the silence of an input on which nothing arrives, and other channels that carry its type."""
        ref, what = intake.source.channel.ref, f"{intake.source.channel.ref} silent"
        silent_s = now_s - max(intake.mailbox.heard_s, self._schedule.clock.start_s)
        if not self._schedule.is_needed(ref) or silent_s <= _SILENT_S - SCAN_S:
            self._told.pop(what, None)
            return
        if topics is not None and intake.source.ros_type is not None:
            if silent_s > _SILENT_S and self._is_news(what, round(silent_s), 1):
                who = f"silent: {ref} has had no message on {intake.source.name} for {silent_s:.0f} s"
                own = {one.name for one in self._schedule.graph.outputs.values()}
                yield f"{who}; {why_silent(intake.source, topics, own)}"
            return
        is_due = silent_s + SCAN_S >= max(_SILENT_S, 2 * self._told.get(what, 0))
        if is_due and self._scan is None and receiver is not None and intake.source.is_channel:
            sources = [one.source for one in self._schedule.intakes.values() if one.source.ros_type is None]
            self._scan = TypeScan(receiver.url, {codec_of(source.lcm_class).fingerprint for source in sources})
        if silent_s <= _SILENT_S or not (self._scan is None or self._scan.is_over):
            return
        if self._is_news(what, round(silent_s), 1):
            others = "".join(f"; {one}" for one in self._same_type(intake))
            yield f"silent: {ref} has had no message on {intake.source.name} for {silent_s:.0f} s{others}"
            self._scan = None

    def _unheard(self, outlet: Outlet, now_s: float, topics: Ros2Node) -> Iterator[str]:
        """Yield that no program subscribes a topic; this run does so itself where it is a motor's."""
        target, run_s = outlet.target, now_s - self._schedule.clock.start_s
        if run_s > _SILENT_S and topics.listeners(target.name) <= target.motor:
            if self._is_news(f"{target.channel.ref} unheard", round(run_s), 1):
                yield f"not heard: no program subscribes {target.name} in {topics.network}"
        else:
            self._told.pop(f"{target.channel.ref} unheard", None)

    def _same_type(self, intake: Intake) -> Iterator[str]:
        """Yield the channels of other programs that carry the type of a silent input."""
        graph, source = self._schedule.graph, intake.source
        own = {one.name for one in graph.channels.values()}
        own |= {one.name for one in graph.inputs.values()} | {one.name for one in graph.outputs.values()}
        found = self._scan.channels(codec_of(source.lcm_class).fingerprint) if self._scan is not None else {}
        for channel, rate_hz in sorted(found.items()):
            if channel not in own:
                yield f"{shown_name(channel)} carries {source.type_name} at {rate_hz:.3g} Hz"

    def _lost(self, intake: Intake) -> Iterator[str]:
        """Yield the rejections and losses of an input."""
        ref, channel = intake.source.channel.ref, intake.source.name
        rejected = intake.monitor.rejected
        news = [
            f"\n  {count} {reason}{': ' * bool(detail)}{detail}"
            for reason, count in rejected.most_common()
            if self._is_news(f"{ref} {reason}", count, _MIN_OVERTAKEN)
            for detail in (intake.monitor.detail(reason),)
        ]
        if news and not intake.monitor.stamp_fault:
            yield f"not used: {rejected.total()} messages of {ref} on {channel}{''.join(news)}"
        if self._is_news(f"{ref} lost", intake.lost, _MIN_LOST):
            yield (
                f"lost: {intake.lost} messages of {ref} on {channel} never arrived, by their sequence numbers\n"
                "  'graphnav doctor' checks whether the receive buffer is large enough"
            )

    def _dropped(self, receiver: Receiver) -> Iterator[str]:
        """Yield packets that the kernel dropped, with the inputs whose messages have several, and what helps."""
        loss = receiver.packet_loss()
        if not self._is_news("packets", loss.packets, _MIN_LOST):
            return
        sizes = {
            f"{intake.source.channel.ref} on {intake.source.name}": intake.mailbox.largest_bytes
            for intake in self._schedule.intakes.values()
            if intake.source.is_channel and (intake.mailbox.largest_bytes > PACKET_BYTES or _is_unheard_picture(intake))
        }
        messages = ", ".join(f"{size_text(size)} of {name}" if size else name for name, size in sizes.items())
        yield (
            f"lost: the kernel dropped {loss.packets} packets that the receive buffer of {loss.buffer_bytes} bytes did "
            f"not hold{'; messages of several packets: ' if messages else ''}{messages}\n"
            f"  {_remedy(receiver.url, max(sizes.values(), default=0))}"
        )

    def _is_news(self, what: str, count: int, minimum: int) -> bool:
        """Whether a count is at minimum ``minimum`` and twice the one reported last."""
        if count < max(minimum, 2 * self._told.get(what, 0)):
            return False
        self._told[what] = count
        return True


def why_silent(source: InputChannel, topics: Ros2Node, own: Collection[str]) -> str:
    """Return what the publishers that were found tell of a topic without messages; ``own``: topics of the run."""
    found = [one for one in topics.publishers() if one.topic not in own]
    types = dict.fromkeys(shown_name(one.type_name) for one in found if one.topic == source.name)
    others = dict.fromkeys(
        shown_name(one.topic) for one in found if one.type_name == source.type_name and one.topic != source.name
    )
    if types and source.type_name not in types:
        return f"its publisher has the type {', '.join(types)}, not {source.type_name}"
    if types and source.channel.message.many_writers:
        return "it has a publisher, which sends nothing or not reliably"
    if types:
        return "it has a publisher, which sends nothing"
    if others:
        return f"{source.type_name} is published on {', '.join(list(others)[:_MAX_NAMED])}"
    reach = " (programs of this machine alone)" if topics.network.interface == LOOPBACK else ""
    return f"no program publishes it in {topics.network}{reach}: is it another domain or interface?"


def _is_unheard_picture(intake: Intake) -> bool:
    """Whether nothing came on an input whose messages are pictures: perhaps because they are too large."""
    return not intake.mailbox.largest_bytes and bool(intake.source.channel.message.grid)


def _remedy(url: str, message_bytes: int) -> str:
    command, option = ReceiveBuffer.larger(Bus.requested_buffer(url), ReceiveBuffer.needed(message_bytes))
    steps = [f"run as root: {command}"] if command else []
    if option:
        steps.append(f"write {option} in the URL")
    if not steps:
        return "the buffer is large enough: this machine is too busy to empty it in time"
    return f"{'; '.join(steps)}, and start again"
