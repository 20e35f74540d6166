"""Stages for the tests of the Python door: a sensor, a gain, a score, and all that can go wrong."""

from __future__ import annotations

import os
import signal
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from threadpoolctl import threadpool_info

from graphnav import Finished, Flow, Metric, Source, Stage, Steering, Twist, hookimpl, param

FAMILY = "door"


class Seen(NamedTuple):
    """Outputs of the sensor."""

    flow: Flow
    twist: Twist


class Sensor(Source):
    """Sees a flow that grows with time; at ``grief_tick`` something happens."""

    name: str = param("", doc="shown nowhere")
    numbers: tuple[float, ...] = param((), doc="not used")
    file: Path | None = param(None, doc="not used")
    noise_px: float = param(0.0, ge=0.0, doc="noise of the flow")
    ticks: int = param(0, ge=0, doc="ticks until the goal; 0 for none")
    grief: Literal["none", "raise", "exit", "interrupt", "grow"] = param("none", doc="what happens")
    grief_tick: int = param(5, ge=0, doc="when it happens")

    def reset(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        self._k = 0

    def step(self) -> Seen:
        self._k += 1
        shape = (4, 6)
        if self._k == self.grief_tick:
            shape = self._come_to_grief(shape)
        uv_px = self._random.normal(self._k, self.noise_px + 1e-9, (*shape, 2)).astype(np.float32)
        seen = Seen(
            Flow(uv_px=uv_px, valid=np.ones(shape, np.uint8), interval_us=100_000),
            Twist(v_mps=float(self._k), omega_radps=0.5),
        )
        if self._k == self.ticks:
            raise Finished("goal", seen)
        return seen

    def _come_to_grief(self, shape: tuple[int, int]) -> tuple[int, int]:
        if self.grief == "raise":
            raise ValueError("worn <b>out</b>")
        if self.grief == "exit":
            raise SystemExit(7)
        if self.grief == "interrupt":
            os.kill(os.getpid(), signal.SIGINT)
        return (5, 6) if self.grief == "grow" else shape


class Steerer(Stage):
    """Forces of a flow, computed by BLAS."""

    def step(self, flow: Flow) -> Steering:
        pushed = np.linalg.lstsq(flow.uv_px.reshape(-1, 2).astype(float), np.ones(flow.valid.size), rcond=None)[0]
        return Steering(
            repulsive=pushed, guiding=np.zeros(2), control=pushed, theta_rad=0.1, eigenvalues=np.array([2.0, 1.0])
        )


class Way(Stage):
    """Scores how far it went, what is not defined, and how many threads a library had at most."""

    metrics: ClassVar = (
        Metric("way_m", unit="m", better="higher", help="How far it went."),
        Metric("undefined", better="higher", help="Not defined."),
        Metric("threads", better="lower", help="Maximum number of threads of a library."),
    )

    def reset(self, seed: int) -> None:
        self._sum = 0.0
        self._threads = 0

    def step(self, twist: Twist) -> None:
        self._sum += twist.v_mps
        self._threads = max(self._threads, *(library["num_threads"] for library in threadpool_info()))

    def summary(self) -> Mapping[str, float]:
        return {"way_m": self._sum, "undefined": float("nan"), "threads": self._threads}


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Sensor, Steerer, Way]
