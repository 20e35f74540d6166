"""Open the connections of a live run to other programs: inputs, outputs and motor channels."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress

from graphnav.bus import Bus
from graphnav.errors import BusError
from graphnav.graph import Graph
from graphnav.live.health.observer import Observer
from graphnav.live.inputs.receiver import Receiver, Takes
from graphnav.live.live_runner import LiveRunner
from graphnav.live.outlet import Outlet, bus_send, motor_channel
from graphnav.motors.sender import MotorSender

_STOPS_S = 1.0
_STOP_PERIOD_S = 0.02


@contextmanager
def opened(
    graph: Graph,
    runner: LiveRunner,
    url: str,
    wake: threading.Event,
    observer: Observer,
) -> Iterator[MotorSender | None]:
    """Open inputs and outputs; yield the sender of the motor channels, None if there are none.

    On exit the motors are always stopped first. ``observer`` counts all messages on the motor channels.
    Raises BusError if LCM cannot be opened.
    """
    with ExitStack() as cleanup:
        motor = {ref: target for ref, target in graph.outputs.items() if target.motor}
        listened: list[tuple[str, Takes]] = [(target.name, observer.traffic) for target in motor.values()]
        listened += [(one.source.name, one.mailbox) for one in runner.intakes.values() if one.source.log is None]
        if listened:
            cleanup.callback(Receiver(url, listened, wake).close)
        others = {ref: target for ref, target in graph.outputs.items() if not target.motor}
        if others:
            bus = Bus(url)
            cleanup.callback(bus.close)
            send = bus_send(bus, observer.tell)
            runner.outlets |= {ref: Outlet(target, runner.clock, send) for ref, target in others.items()}
        motors = None
        if motor:
            motors = observer.traffic.motors = MotorSender(url, [motor_channel(target) for target in motor.values()])
            cleanup.callback(motors.close)
            runner.outlets |= {ref: Outlet(target, runner.clock, motors.send) for ref, target in motor.items()}
        yield motors


def send_stops(graph: Graph, url: str) -> None:
    """Send the stops of all motor channels from this process for a second, as a last resort; never raises."""
    channels = [motor_channel(target) for target in graph.outputs.values() if target.motor]
    with suppress(BusError):
        bus = Bus(url)
        end_s = time.monotonic() + _STOPS_S
        while time.monotonic() < end_s:
            for channel in channels:
                bus.publish(channel.name, channel.stop)
            time.sleep(_STOP_PERIOD_S)
        bus.close()
