"""The navigation graph by hand: one python-lcm loop that calls the same stages, without graphnav's runner.

What `bench_live.py` measures live graphs against: it listens, decodes with lcm-gen's own classes, makes the flow of a
frame when it comes, waits for the odometry after the frame, steps the rest and publishes. It keeps no log, supervises
nothing and counts nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import lcm
import numpy as np
from graphnav_flow.lucas_kanade import FlowOutputs
from graphnav_lcm import image_t, odometry_t, twist_t

from graphnav import Image, Latest, Odometry, Since
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph
from graphnav.core.graph.overrides.override import Override

GRAPH = "navigate_live"


class Bare:
    """Steps the flow when a frame has come, and the other stages when the odometry after it has come too."""

    def __init__(self, url: str, sets: Sequence[str]) -> None:
        self._lcm = lcm.LCM(url)
        self._stages: dict[str, Any] = dict(load_graph(GRAPH, Catalog(), Override.parse_all(sets, [])).make_stages())
        for stage in self._stages.values():
            stage.reset(0)
        self._seen: tuple[int, Image, FlowOutputs] | None = None
        self._samples: list[tuple[int, Odometry]] = []
        self._lcm.subscribe("CAMERA", self._see).set_queue_capacity(0)
        self._lcm.subscribe("ODOMETRY", self._count).set_queue_capacity(0)

    def run(self) -> None:
        """Handle messages for ever."""
        while True:
            self._lcm.handle()

    def _see(self, _channel: str, data: bytes) -> None:
        frame = image_t.decode(data)
        image = Image(pixels=np.frombuffer(frame.data, np.uint8).reshape(frame.rows, frame.cols))
        made = self._stages["flow"].step(image, frame.utime)
        if made is not None:
            self._seen = frame.utime, image, made
            self._step_when_covered()

    def _count(self, _channel: str, data: bytes) -> None:
        sample = odometry_t.decode(data)
        message = Odometry(
            x_m=sample.x_m, y_m=sample.y_m, yaw_rad=sample.yaw_rad, v_mps=sample.v_mps, omega_radps=sample.omega_radps
        )
        self._samples.append((sample.utime, message))
        self._step_when_covered()

    def _step_when_covered(self) -> None:
        if self._seen is None or not self._samples or self._samples[-1][0] < self._seen[0]:
            return
        (utime, image, (flow, deviation)), self._seen = self._seen, None
        stages = self._stages
        since, self._samples = Since(tuple(self._samples)), []
        motion, check = stages["motion"].step(flow, since, utime)
        if motion is None:
            return
        planar = stages["planar"].step(flow, motion)
        plane = stages["plane"].step(flow, planar, utime).plane
        nothing: Latest[Any] = Latest(is_connected=False)
        steering = stages["steer"].step(plane, nothing, nothing).steering
        command = stages["control"].step(steering, nothing, utime)
        sampled = (Latest(message, 0.0) for message in (plane, image, flow, deviation, motion, check))
        guarded = stages["guard"].step(command, *sampled, nothing, nothing, utime, 0.0)
        out = twist_t()
        out.utime, out.v_mps, out.omega_radps = utime, guarded.twist.v_mps, guarded.twist.omega_radps
        self._lcm.publish("BASE_CMD", out.encode())


if __name__ == "__main__":
    Bare(sys.argv[1], sys.argv[2:]).run()
