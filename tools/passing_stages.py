"""Stages that only pass something on: what a tick costs without work, the way of a picture, many channels at once."""

from __future__ import annotations

import statistics
import time
from collections.abc import Mapping
from inspect import Parameter, Signature
from typing import ClassVar, NamedTuple

import numpy as np

from graphnav import Image, Metric, Source, Stage, Twist, hookimpl, param
from graphnav.arrays import Bytes

FAMILY = "passing"


class Start(Source):
    """Publishes a command."""

    def step(self) -> Twist:
        """Return a command that drives."""
        return Twist(v_mps=0.1, omega_radps=0.0)


class Pass(Stage):
    """Publishes what it gets."""

    def step(self, twist: Twist) -> Twist:
        """Return the command."""
        return twist


N_CHANNELS = 75
Commands = NamedTuple("Commands", [(f"c{k}", Twist) for k in range(N_CHANNELS)])  # type: ignore[misc]
"""Outputs of `Send`: as many channels."""


class Send(Source):
    """Publishes a command on each of its channels."""

    def step(self) -> Commands:
        """Return commands that drive."""
        return Commands(*[Twist(v_mps=0.1, omega_radps=0.0)] * N_CHANNELS)


class Take(Stage):
    """Counts the sets of commands that arrive."""

    metrics: ClassVar[tuple[Metric, ...]] = (Metric("sets", better="neither", help="How many sets arrived."),)

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget what has arrived."""
        self._n = 0

    def step(self, **_: Twist) -> None:
        """Count a set."""
        self._n += 1

    def summary(self) -> Mapping[str, float]:
        """Return the count."""
        return {"sets": float(self._n)}


Take.step.__annotations__ = {**dict.fromkeys(Commands._fields, Twist), "return": None}
Take.step.__signature__ = Signature(  # type: ignore[attr-defined]
    [Parameter(name, Parameter.POSITIONAL_OR_KEYWORD) for name in ("self", *Commands._fields)]
)


class Show(Source):
    """Publishes pictures that tell when they were made."""

    rows: int = param(120, ge=1, doc="rows of the picture")
    cols: int = param(160, ge=8, doc="columns of the picture")

    def step(self) -> Image:
        """Return a picture."""
        return Image(pixels=timed_picture(self.rows, self.cols))


class Arrive(Stage):
    """Tells how long pictures of `Show` were on their way."""

    metrics: ClassVar[tuple[Metric, ...]] = (
        Metric("p50_us", unit="µs", better="lower", help="Median time from a picture's making to its arrival, in µs."),
        Metric("p90_us", unit="µs", better="lower", help="The time within which nine of ten arrive, in µs."),
        Metric("pictures", better="neither", help="How many arrived."),
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget what has arrived."""
        self._hops_us: list[float] = []

    def step(self, image: Image) -> None:
        """Count a picture."""
        self._hops_us.append(age_us(image.pixels))

    def summary(self) -> Mapping[str, float]:
        """Return the times."""
        return hop_statistics(self._hops_us)


def timed_picture(rows: int, cols: int) -> Bytes:
    """Return a picture, (rows, cols), whose first eight pixels are the time, monotonic, in ns."""
    pixels = np.full((rows, cols), 100, np.uint8)
    pixels[0, :8] = np.frombuffer(time.monotonic_ns().to_bytes(8, "little"), np.uint8)
    return pixels


def age_us(pixels: Bytes) -> float:
    """Return how long ago a picture of `timed_picture` was made, µs."""
    return (time.monotonic_ns() - int.from_bytes(pixels[0, :8].tobytes(), "little")) / 1e3


def hop_statistics(hops_us: list[float]) -> dict[str, float]:
    """Return median and ninth decile of times, and how many there are; without the first tenth, to warm up."""
    counted = hops_us[len(hops_us) // 10 :]
    deciles = statistics.quantiles(counted, n=10)
    return {"p50_us": statistics.median(counted), "p90_us": deciles[8], "pictures": float(len(hops_us))}


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return them."""
    return [Start, Pass, Send, Take, Show, Arrive]
