"""Open the connections of a live run to other programs: inputs, outputs and motor channels."""

from __future__ import annotations

import math
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress

from graphnav import Graph, GraphnavError
from graphnav.core.bus import Bus
from graphnav.core.errors import BusError
from graphnav.core.graph import OutputChannel
from graphnav.live.health.observer import Observer
from graphnav.live.inputs.packet_sources import PacketSources
from graphnav.live.inputs.receiver import Receiver, Takes
from graphnav.live.live_schedule import LiveSchedule
from graphnav.live.motors.schedule import STOP_FOR_S, STOP_PERIOD_S
from graphnav.live.motors.sender import MotorSender
from graphnav.live.motors.stop_message import StopMessage
from graphnav.live.outlet import Outlet, bus_send, motor_channel


class MotorLink:
    """The process that sends the motor channels, and the stops that the run sends in its place if it cannot.

    Raises BusError if LCM cannot be opened.
    """

    def __init__(self, url: str, targets: list[OutputChannel], observer: Observer) -> None:
        channels = [motor_channel(target) for target in targets]
        self._bus = Bus(url)
        self._stops = [(channel.name, StopMessage(channel)) for channel in channels]
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
        self._bus.close()

    def _stop_for_a_second(self) -> None:
        end_s = time.monotonic() + STOP_FOR_S
        while (now_s := time.monotonic()) < end_s:
            self._stop(now_s)
            time.sleep(STOP_PERIOD_S)

    def _stop(self, now_s: float) -> None:
        for name, message in self._stops:
            with suppress(BusError):
                self._bus.publish(name, message.stop(now_s))
                self._observer.traffic.substituted += 1


@contextmanager
def opened(
    graph: Graph,
    schedule: LiveSchedule,
    url: str,
    wake: threading.Event,
    observer: Observer,
) -> Iterator[MotorLink | None]:
    """Open inputs and outputs; yield the link to the motor channels, None if there are none.

    On exit the motors are always stopped first. ``observer`` watches the motor channels.
    Raises BusError if LCM cannot be opened.
    """
    with ExitStack() as cleanup:
        motor = {ref: target for ref, target in graph.outputs.items() if target.motor}
        listened: list[tuple[str, Takes]] = [(target.name, observer.traffic) for target in motor.values()]
        heard = [one for one in schedule.intakes.values() if one.source.log is None]
        listened += [(one.source.name, one.mailbox) for one in heard]
        if listened:
            receiver = observer.receiver = Receiver(url, listened, wake)
            cleanup.callback(receiver.close)
        if heard:
            sources = PacketSources(receiver.url, {one.source.name for one in heard})
            cleanup.callback(sources.close)
            for one in heard:
                one.sources = sources
        others = {ref: target for ref, target in graph.outputs.items() if not target.motor}
        if others:
            bus = Bus(url, observer.tell)
            cleanup.callback(bus.close)
            if any(target.channel.message.grid for target in others.values()):
                bus.expect_large()
            send = bus_send(bus, observer.tell)
            schedule.outlets |= {
                ref: Outlet(target, schedule.clock, send, bus.overtaken) for ref, target in others.items()
            }
        motors = None
        if motor:
            motors = MotorLink(url, list(motor.values()), observer)
            cleanup.callback(motors.close)
            schedule.outlets |= {
                ref: Outlet(target, schedule.clock, motors.sender.send) for ref, target in motor.items()
            }
        yield motors
