"""Stages that read true data and scores, and an adapter that hides true data: what the graphs here are made of."""

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

import graphnav_lcm
import numpy as np

from graphnav import (
    Adapter,
    Flow,
    Latest,
    Map,
    Motion,
    Odometry,
    Plane,
    Role,
    Since,
    Source,
    Stage,
    Stamped,
    State,
    Truth,
    hookimpl,
)

FAMILY = "roles"


class Known(NamedTuple):
    truth: Truth
    state: Stamped[State]


class World(Source):
    """A world that knows everything."""

    def step(self, flow: Latest[Flow]) -> Known | None:
        return None


class Peek(Stage):
    """A method that reads the truth."""

    def step(self, truth: Truth) -> Flow | None:
        return None


class Sample(Stage):
    """A baseline that samples the truth and what has happened."""

    role: ClassVar[Role] = "baseline"

    def step(self, flow: Flow, map: Latest[Map], state: Since[State]) -> Plane | None:  # noqa: A002  # the port's name
        return None


class Oracle(Stage):
    """An oracle, which may."""

    role: ClassVar[Role] = "oracle"

    def step(self, truth: Truth) -> Flow | None:
        return None


class Judge(Stage):
    """A score that publishes what it found."""

    role: ClassVar[Role] = "score"

    def step(self, flow: Flow, truth: Truth) -> Flow | None:
        return flow


class Referee(Stage):
    """A score and a guard, which it cannot be both."""

    role: ClassVar[Role] = "score"
    is_guard = True

    def step(self, flow: Flow | None) -> Flow | None:
        return flow


class Reader(Stage):
    """A method that reads a flow."""

    def step(self, flow: Flow) -> Plane | None:
        return None


class Follow(Stage):
    """A method that reads odometry."""

    def step(self, odometry: Odometry) -> Motion | None:
        return None


class PoseOfTruth(Adapter):
    """Odometry made of the true state."""

    type_name = "graphnav_lcm.state_t"
    lcm_class = graphnav_lcm.state_t
    message = Odometry

    def from_lcm(self, fields: Mapping[str, Any]) -> Odometry:
        names = ("x_m", "y_m", "yaw_rad", "v_mps", "omega_radps")
        return Odometry(**{name: float(np.float64(fields[name])) for name in names})


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [World, Peek, Sample, Oracle, Judge, Referee, Reader, Follow]


@hookimpl
def graphnav_adapters() -> list[type[Adapter]]:
    return [PoseOfTruth]
