"""Open the connections of a live run to other programs: inputs, outputs and motor channels."""

from __future__ import annotations

import math
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress

from graphnav import Graph, GraphnavError, Problem, Ros2Adapter, UserError
from graphnav.core.bus import Bus
from graphnav.core.dds import Ros2Node
from graphnav.core.errors import BusError
from graphnav.core.graph import InputChannel, OutputChannel
from graphnav.core.ros2 import Ros2Network
from graphnav.live.health.observer import Observer
from graphnav.live.inputs.intake import GATHERED
from graphnav.live.inputs.packet_sources import PacketSources
from graphnav.live.inputs.receiver import NEWEST, Receiver, Takes
from graphnav.live.inputs.topic_receiver import Listened, TopicReceiver
from graphnav.live.live_schedule import LiveSchedule
from graphnav.live.motors.links import MotorLinks
from graphnav.live.motors.schedule import STOP_FOR_S, STOP_PERIOD_S
from graphnav.live.motors.sender import MotorSender
from graphnav.live.motors.stop_message import StopMessage
from graphnav.live.outlet import Outlet, bus_send, motor_channel, topic_send


class MotorLink:
    """The process that sends the motor channels, and the stops that the run sends in its place if it cannot.

    ``node``: the run's participant in ROS 2, None where nothing is a topic. Raises BusError if LCM or a topic cannot be
    opened.
    """

    def __init__(self, url: str, targets: list[OutputChannel], observer: Observer, node: Ros2Node | None) -> None:
        network = Ros2Network() if node is None else node.network
        channels = [motor_channel(target, network) for target in targets]
        self._links = MotorLinks(url, channels, node)
        self._stops = [(channel.name, self._links.of(channel), StopMessage(channel)) for channel in channels]
        self._max_age_s = min(channel.max_age_s for channel in channels)
        self._observer = observer
        self._due_s = -math.inf
        self.sender = observer.traffic.motors = MotorSender(url, channels)

    def check(self) -> None:
        """Send a stop if the process has left commands unread for ``max_age_s``; called at every turn.

        Raises
        ------
        GraphnavError
            The process has died; this process has sent stops for a second.
        """
        if not self.sender.alive:
            self._stop_for_a_second()
            raise GraphnavError("the process that sends the motor channels has died: the run cannot go on")
        now_s = time.monotonic()
        if now_s >= self._due_s and self.sender.unread_s(now_s) > self._max_age_s:
            self._due_s = now_s + STOP_PERIOD_S
            self._stop(now_s)

    def close(self) -> None:
        """Stop the motors and end the process; one that does not react is killed after stops from this process."""
        is_stalled = self.sender.alive and self.sender.unread_s(time.monotonic()) > 0.0
        self.sender.close(wait=not is_stalled)
        if self.sender.alive:
            self._observer.tell(
                f"motors: the process that sends the motor channels (pid {self.sender.pid}) does not react at the end: "
                "the run sends the stops itself"
            )
            self._stop_for_a_second()
            with suppress(ProcessLookupError):
                os.kill(self.sender.pid, signal.SIGKILL)
        self._links.close()

    def _stop_for_a_second(self) -> None:
        end_s = time.monotonic() + STOP_FOR_S
        while (now_s := time.monotonic()) < end_s:
            self._stop(now_s)
            time.sleep(STOP_PERIOD_S)

    def _stop(self, now_s: float) -> None:
        for name, link, message in self._stops:
            with suppress(BusError):
                link.publish(name, message.stop(now_s))
                self._observer.traffic.substituted += 1


@contextmanager
def opened(
    graph: Graph,
    schedule: LiveSchedule,
    url: str,
    node: Ros2Node | None,
    wake: threading.Event,
    observer: Observer,
) -> Iterator[MotorLink | None]:
    """Open inputs and outputs; yield the link to the motor channels, None if there are none.

    On exit the motors are always stopped first. ``node``: see `joined_ros2`. ``observer`` watches the motor channels.
    Raises BusError if LCM or a topic cannot be opened.
    """
    with ExitStack() as cleanup:
        motor = {ref: target for ref, target in graph.outputs.items() if target.motor}
        others = {ref: target for ref, target in graph.outputs.items() if not target.motor}
        observer.topics = node
        _open_inputs(graph, schedule, url, wake, observer, node, cleanup)
        sent = {ref: target for ref, target in others.items() if target.ros_type is None}
        if sent:
            bus = Bus(url, observer.tell)
            cleanup.callback(bus.close)
            if any(target.channel.message.grid for target in sent.values()):
                bus.expect_large()
            send = bus_send(bus, observer.tell)
            schedule.outlets |= {
                ref: Outlet(target, schedule.clock, send, bus.overtaken) for ref, target in sent.items()
            }
        for ref, target in others.items():
            if node is not None and target.ros_type is not None:
                latched = isinstance(target.adapter, Ros2Adapter) and target.adapter.latched
                node.offer(target.name, target.ros_type, latched=latched)
                schedule.outlets[ref] = Outlet(target, schedule.clock, topic_send(node, observer.tell))
        motors = None
        if motor:
            motors = MotorLink(url, list(motor.values()), observer, node)
            cleanup.callback(motors.close)
            schedule.outlets |= {
                ref: Outlet(target, schedule.clock, motors.sender.send) for ref, target in motor.items()
            }
        yield motors


def _open_inputs(
    graph: Graph,
    schedule: LiveSchedule,
    url: str,
    wake: threading.Event,
    observer: Observer,
    node: Ros2Node | None,
    cleanup: ExitStack,
) -> None:
    """Listen to the channels and topics of inputs, and to those of motor outputs, on which others may send."""
    motor = [target for target in graph.outputs.values() if target.motor]
    heard = [one for one in schedule.intakes.values() if one.source.is_channel]
    listened: list[tuple[str, Takes]] = [(one.name, observer.traffic) for one in motor if one.ros_type is None]
    listened += [(one.source.name, one.mailbox) for one in heard]
    if listened:
        receiver = observer.receiver = Receiver(url, listened, wake)
        cleanup.callback(receiver.close)
    if heard:
        sources = PacketSources(receiver.url, {one.source.name for one in heard})
        cleanup.callback(sources.close)
        for one in heard:
            one.sources = sources
    if node is None:
        return
    topics = [Listened(one.name, one.ros_type, observer.traffic) for one in motor if one.ros_type is not None]
    subscribed = [one for one in schedule.intakes.values() if one.source.ros_type is not None]
    for one in subscribed:
        assert one.source.ros_type is not None
        is_stop = one.source.channel.message.many_writers  # no message of which may be lost
        depth = GATHERED if one.needs_all else NEWEST
        topics.append(Listened(one.source.name, one.source.ros_type, one.mailbox, depth, is_stop))
    topic_receiver = TopicReceiver(node, topics, wake)
    cleanup.callback(topic_receiver.close)
    for one in subscribed:
        one.sources = topic_receiver


@contextmanager
def joined_ros2(graph: Graph) -> Iterator[Ros2Node | None]:
    """Join ROS 2 for the topics of a graph; yield the participant, None if it has none.

    Raises
    ------
    UserError
        Cyclone DDS is not installed, or the interface does not exist.
    BusError
        The domain cannot be joined.
    """
    users: list[tuple[str, InputChannel | OutputChannel]]
    users = [(f"the input '{ref}'", one) for ref, one in graph.inputs.items() if one.ros_type is not None]
    users += [(f"the output '{ref}'", one) for ref, one in graph.outputs.items() if one.ros_type is not None]
    if not users:
        yield None
        return
    (who, first), network = users[0], graph.ros2.resolved()
    try:
        node = Ros2Node(network, f"{who} with ros2")
    except UserError as error:
        raise UserError([Problem(first.place, one.what, one.hint) for one in error.problems]) from error
    with closing(node):
        yield node
