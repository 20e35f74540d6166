"""A drive through a room, as messages: camera, flow, plane, command, and hostile names and strings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from graphnav.core.catalog import Catalog
from graphnav.core.codec import encode
from graphnav.core.graph import load_graph
from graphnav.core.messages import About, Flow, Image, Map, Message, Plane, State, Status, Steering, Stop, Twist
from graphnav.core.runner import ProcessState
from graphnav.core.runner.recording.run_recorded import about_of

N_FRAMES = 40
PERIOD_US = 100_000
MARKUP = "<img/src=x/onerror=alert(1)>"
"""A channel's name that a careless page would run."""


def about() -> About:
    """Return what a run of the shipped corridor says of itself."""
    return about_of(load_graph("corridor_ccw", Catalog()))


def frame_of(k: int) -> dict[str, Message]:
    """Return the messages of the k-th frame of a drive."""
    rows, cols = 12, 16
    y, x = np.mgrid[0:rows, 0:cols]
    uv = np.stack([(x - 8) / 8, (y - 6) / 6], axis=-1).astype(np.float32)
    obstacle = (x + k % 8 > 18).astype(np.uint8)
    ones = np.ones((rows, cols), np.uint8)
    turn = 0.02 * k
    return {
        "robot.image": Image(((x * 12 + y * 4 + 3 * k) % 255).astype(np.uint8)),
        "robot.state": State(
            0.1 * k, 0.3 * np.sin(turn), turn, 1.0, 0.2, 0.8, contact=False, at_goal=False, moving=np.empty((0, 3))
        ),
        "flow.flow": Flow(uv, ones, PERIOD_US),
        "plane.plane": Plane(obstacle, obstacle.astype(np.float32), ones, 1, float(obstacle.mean())),
        "steer.steering": Steering(np.array([0.1, 0.2]), np.array([0.0, 1.0]), np.array([0.1, 1.2]), turn, np.ones(2)),
        "control.twist": Twist(0.3, 0.1 * np.sin(turn)),
    }


def world() -> Map:
    """Return a room of 5 m by 2 m with one pillar."""
    pillar = np.array([[3, 0.4], [3.4, 0.4], [3.4, 0.8], [3, 0.8]])
    wall = np.array([[-1, -1.1], [5, -1.1], [5, -1.0], [-1, -1.0]])
    return Map(
        kind=np.array([0, 0, 1], np.uint8),
        height_m=np.ones(3),
        vertices_m=np.concatenate([wall, wall + np.array([0, 2.1]), pillar]),
        body=np.repeat(np.arange(3, dtype=np.int32), 4),
        start=np.zeros(3),
        goal_m=np.array([[4.3, -0.5], [4.9, -0.5], [4.9, 0.5], [4.3, 0.5]]),
        robot_radius_m=0.15,
        shortest_m=4.3,
        footprint_m=np.array([[0.2, -0.2], [1.2, -0.6], [1.2, 0.6], [0.2, 0.2]]),
    )


def status(k: int) -> Status:
    """Return the health of the run at the k-th frame."""
    stages = ("robot", "flow", "planar", "plane", "steer", "control", "drive")
    return Status(
        run_id="",
        graph="corridor_ccw",
        live=False,
        wall_s=0.1 * k,
        run_s=0.1 * k,
        behind_s=0.0,
        memory_mb=151.0,
        tap_dropped=0,
        log_dropped=0,
        log_fault="",
        stages=tuple(
            {
                "name": name,
                "use": "x.y",
                "steps": k,
                "rate_hz": 10.0,
                "p50_ms": 1.5 + place,
                "p99_ms": 4.5 + place,
                "deadline_ms": 0.0,
                "missed": 0,
                "overtaken": 0,
                "restarts": 0,
            }
            for place, name in enumerate(stages)
        ),
        inputs=(),
        outputs=(),
        edges=({"name": "plane.flow", "channel": "flow.flow", "overtaken": 4},),
    )


def process_status(
    name: str, stages: tuple[str, ...], state: Literal["ready", "restarting"] = "ready", restarts: int = 0
) -> dict[str, Any]:
    """Return the health of a process."""
    load = {"cpu_ratio": 0.254, "memory_mb": 61.7}
    return ProcessState(name, stages, 4242 if state == "ready" else 0, state, restarts)._asdict() | load


def status_of_processes(k: int) -> Status:
    """Return the health of a run over three processes, of which one is being started again."""
    clock = {"round_trip_ms": 0.41, "clock_offset_s": 0.0123, "clock_error_s": 0.0002, "clock_steps": 1}
    edges = (("plane.flow", "flow.flow", 4), ("flow.image", "robot.image", 0), ("steer.plane", "plane.plane", 0))
    return replace(
        status(k),
        live=True,
        edges=tuple({"name": name, "channel": ref, "overtaken": n} for name, ref, n in edges),
        processes=(
            process_status("", ("robot", "planar", "control", "drive")),
            process_status("eyes", ("flow", "plane")) | {"host": "jetson"} | clock,
            process_status(MARKUP, ("steer",), "restarting", 2),
        ),
    )


def messages() -> Iterator[tuple[str, int, bytes]]:
    """Yield channel, stamp and bytes of a drive; every fifth steering is lost, and a name and a string are hostile."""
    yield About.CHANNEL, 0, encode(about(), 0, 0)
    yield "robot.map", 0, encode(world(), 0, 0)
    for k in range(N_FRAMES):
        for channel, message in frame_of(k).items():
            if channel != "steer.steering" or k % 5:
                yield channel, k * PERIOD_US, encode(message, k * PERIOD_US, k)
        if k % 10 == 0:
            yield "graphnav.status", k * PERIOD_US, encode(status(k), k * PERIOD_US, k // 10)
            hostile = Stop(engaged=True, reason="<script>alert(2)</script>\x1b[31m")
            yield MARKUP, k * PERIOD_US, encode(hostile, k * PERIOD_US, k // 10)
