"""The graph `corridor_ccw` by hand: one python-lcm loop that calls the same stages, without graphnav's runner.

It encodes and decodes by hand, checks every message for NaN, publishes what a stage reads and logs everything.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from time import perf_counter
from typing import Any

import lcm
from hand_written_types import PUT, TAKE

from graphnav import Latest
from graphnav.core.codec import encode
from graphnav.core.runner import seed_of

PERIOD_US = 100_000


class HandWrittenLoop:
    """Steps the stages of a graph, by name, in order; a stage gets the messages that came back from LCM."""

    def __init__(self, stages: Mapping[str, Any], seed: int, log: Path) -> None:
        self.inside_s = 0.0
        """The time in the stages' steps so far."""
        self._stages = stages
        for name, stage in stages.items():
            stage.reset(seed_of(seed, name))
        self._has_scores = "sense" in stages
        self._read = TAKE.keys() if self._has_scores else TAKE.keys() - {"robot.state", "robot.truth"}
        self._map: Any = None
        self._seqs = dict.fromkeys(PUT, 0)
        self._inbox: dict[str, tuple[int, Any]] = {}
        self._utime = 0
        self._n_ticks = 0
        self._lcm = lcm.LCM("memq://")
        self._log = lcm.EventLog(str(log), "w", overwrite=True)
        for channel in self._read:
            self._lcm.subscribe(channel, self._receive)

    def tick(self) -> None:
        """Step every stage once."""
        self._utime = utime = self._n_ticks * PERIOD_US
        self._n_ticks += 1
        inbox = self._inbox
        robot = self._step("robot", command=self._newest("guard.twist"), utime=utime)
        self._send("robot.image", robot.image)
        self._send("robot.motion", robot.motion)
        self._send("robot.state", robot.state)
        self._send("robot.truth", robot.truth)
        self._send("robot.goal", robot.goal)
        if robot.map is not None:
            self._map = utime, robot.map
            self._log.write_event(utime, "robot.map", encode(robot.map, utime, 0))
        made = self._step("flow", image=inbox["robot.image"][1], stamp=utime)
        if made is not None:
            self._send("flow.flow", made.flow)
            self._send("flow.deviation", made.deviation)
            self._navigate(utime)
        if self._has_scores:
            seen, map_ = inbox["robot.state"], Latest(self._map[1], (utime - self._map[0]) / 1e6)
            self._step("drive", state=seen[1], map=map_, stamp=utime)
            if made is not None:
                truth = inbox["robot.truth"][1]
                self._step("sense", flow=inbox["flow.flow"][1], truth=truth)
                self._step("sight", plane=inbox["plane.plane"][1], truth=truth)
                self._step("heading", steering=inbox["steer.steering"][1], truth=truth)

    def close(self) -> None:
        """Close the stages and the log."""
        self._log.close()
        for stage in self._stages.values():
            stage.close()

    def _navigate(self, utime: int) -> None:
        inbox = self._inbox
        flow, nothing = inbox["flow.flow"][1], Latest[Any](is_connected=False)
        self._send("planar.planar", self._step("planar", flow=flow, motion=inbox["robot.motion"][1]))
        judged = self._step("plane", flow=flow, planar=inbox["planar.planar"][1], stamp=utime)
        self._send("plane.plane", judged.plane)
        steered = self._step("steer", plane=inbox["plane.plane"][1], goal=nothing, planar=nothing)
        self._send("steer.steering", steered.steering)
        self._send("steer.potential", steered.potential)
        self._send(
            "control.twist", self._step("control", steering=inbox["steer.steering"][1], stamp=utime, map=nothing)
        )
        guarded = self._step(
            "guard",
            command=inbox["control.twist"][1],
            plane=self._newest("plane.plane"),
            image=self._newest("robot.image"),
            flow=self._newest("flow.flow"),
            deviation=self._newest("flow.deviation"),
            motion=nothing,
            odometry=nothing,
            override=nothing,
            stop=nothing,
            utime=utime,
            command_age_s=0.0,
        )
        self._send("guard.twist", guarded.twist)
        self._send("guard.state", guarded.state)

    def _step(self, name: str, **inputs: Any) -> Any:
        begin = perf_counter()
        result = self._stages[name].step(**inputs)
        self.inside_s += perf_counter() - begin
        return result

    def _newest(self, channel: str) -> Latest[Any]:
        if channel not in self._inbox:
            return Latest()
        utime, message = self._inbox[channel]
        return Latest(message, (self._utime - utime) / 1e6)

    def _send(self, channel: str, message: Any) -> None:
        if message is None:
            return
        data = PUT[channel](self._utime, self._seqs[channel], message)
        self._seqs[channel] += 1
        self._log.write_event(self._utime, channel, data)
        if channel in self._read:
            self._lcm.publish(channel, data)
            self._lcm.handle()

    def _receive(self, channel: str, data: bytes) -> None:
        self._inbox[channel] = TAKE[channel](data)
