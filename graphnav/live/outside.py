"""What a live run opens towards other programs: what it hears, what it sends, what moves motors."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from graphnav.bus import Bus
from graphnav.graph import Graph
from graphnav.live.live_runner import LiveRunner
from graphnav.live.outlet import Outlet, bus_send, motor_channel
from graphnav.live.receiver import Receiver
from graphnav.motors.sender import MotorSender


@contextmanager
def opened(
    graph: Graph, runner: LiveRunner, url: str, wake: threading.Event, notice: Callable[[str], None]
) -> Iterator[MotorSender | None]:
    """Open what comes in and what leaves, and yield what sends the motor channels, if any do.

    Whatever happens then, the motors are stopped first. Raises BusError where LCM cannot be opened.
    """
    with ExitStack() as cleanup:
        listened = [(one.source.name, one.mailbox) for one in runner.intakes.values() if one.source.log is None]
        if listened:
            cleanup.callback(Receiver(url, listened, wake).close)
        others = {ref: target for ref, target in graph.outputs.items() if not target.motor}
        if others:
            bus = Bus(url)
            cleanup.callback(bus.close)
            send = bus_send(bus, notice)
            runner.outlets |= {ref: Outlet(target, runner.clock, send) for ref, target in others.items()}
        motor = {ref: target for ref, target in graph.outputs.items() if target.motor}
        motors = None
        if motor:
            motors = MotorSender(url, [motor_channel(target) for target in motor.values()])
            cleanup.callback(motors.close)
            runner.outlets |= {ref: Outlet(target, runner.clock, motors.send) for ref, target in motor.items()}
        yield motors
