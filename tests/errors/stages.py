"""Stages of the family ``toy``: what the broken graphs are made of."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, NamedTuple

import graphnav_lcm
import numpy as np

from graphnav import (
    Adapter,
    Flow,
    Image,
    Latest,
    Motion,
    ParamError,
    Plane,
    Source,
    Stage,
    Stamp,
    Steering,
    Twist,
    hookimpl,
    param,
)

FAMILY = "toy"


class Seen(NamedTuple):
    image: Image
    motion: Motion


class Robot(Source):
    """A camera on wheels that sees noise."""

    map: Path | None = param(None, doc="a map of the floor")
    noise_px: float = param(2.0, ge=0.0, doc="standard deviation of the image's noise; more hides the texture")

    def reset(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)

    def check(self) -> None:
        if self.map is not None and not self.map.is_file():
            raise ParamError("map", f"there is no map {self.map.name}", "name a file")

    def step(self, now: Stamp, command: Latest[Twist]) -> Seen:
        pixels = self._random.integers(0, 255, (12, 16), dtype=np.uint8)
        forward_m = command.value.v_mps / 10 if command.value else 0.0
        return Seen(Image(pixels=pixels), Motion(forward_m=forward_m, left_m=0.0, turn_rad=0.0, interval_us=100_000))


class Matcher(Stage):
    """Flow of an image."""

    layers: int = param(3, ge=1, le=8, doc="layers of the pyramid")

    def step(self, image: Image) -> Flow:
        shape = image.pixels.shape[:2]
        return Flow(uv_px=np.zeros((*shape, 2), np.float32), valid=np.ones(shape, np.uint8), interval_us=100_000)


class Smooth(Stage):
    """Flow of a flow."""

    alpha: float = param(0.5, ge=0.0, le=1.0, doc="weight of the newest flow")

    def step(self, flow: Flow) -> Flow:
        return flow


class Mix(Stage):
    """Flow of two flows."""

    def step(self, first: Flow, second: Flow) -> Flow:
        return first if second.step_px else second


class Detector(Stage):
    """Dominant plane of a flow."""

    rule: Literal["mad", "otsu"] = param("mad", doc="how the threshold is found")
    limits: tuple[float, float] = param((0.0, 1.0), doc="least and greatest threshold")
    model: Path | None = param(None, doc="a planar model")
    strict: bool = param(False, doc="whether invalid vectors are obstacle")

    def step(self, flow: Flow) -> Plane:
        return _empty(flow.valid.shape)


class Guess(Stage):
    """Dominant plane of a motion, another way to find it."""

    model: Path | None = param(None, doc="a planar model")
    share: float = param(0.5, doc="share of the ground")

    def step(self, motion: Motion) -> Plane:
        return _empty((12, 16))


class FromFlows(Stage):
    """Dominant plane of two flows."""

    def step(self, flow: Flow, other: Flow) -> Plane:
        return _empty(flow.valid.shape)


class Taught(Stage):
    """Dominant plane of a flow and a model that a graph has to name."""

    model: Path = param(doc="a planar model")

    def step(self, flow: Flow) -> Plane:
        return _empty(flow.valid.shape)


class Wheels(Stage):
    """A command of a plane."""

    def step(self, plane: Plane) -> Twist:
        return Twist(v_mps=1.0 - plane.obstacle_ratio, omega_radps=0.0)


class Guard(Stage):
    """A command that may pass."""

    is_guard = True

    def step(self, command: Twist | None, plane: Latest[Plane]) -> Twist:
        return command or Twist(v_mps=0.0, omega_radps=0.0)


class Rudder(Stage):
    """A guard of what nothing here stops."""

    is_guard = True

    def step(self, command: Twist) -> Steering:
        zeros = np.zeros(2)
        return Steering(repulsive=zeros, guiding=zeros, control=zeros, theta_rad=0.0, eigenvalues=zeros)


class Score(Stage):
    """A sink."""

    def step(self, plane: Plane, motion: Latest[Motion]) -> None:
        return None


class Helm(Stage):
    """A plane that listens to a steering that no stage writes."""

    def step(self, steering: Steering) -> Twist:
        return Twist(v_mps=0.0, omega_radps=0.0)


class Idle(Stage):
    """Nothing fires it."""

    def step(self, motion: Latest[Motion]) -> Twist:
        return Twist(v_mps=0.0, omega_radps=0.0)


class Eager(Source):
    """A source that also waits."""

    def step(self, image: Image) -> Flow:
        raise NotImplementedError


class Untyped(Stage):
    """Its ports cannot be read."""

    def step(self, image):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
        return image


class WheelSpeeds(Adapter):
    """A command for wheels."""

    type_name = "toy.wheels_t"
    lcm_class = graphnav_lcm.stop_t
    message = Twist

    def to_lcm(self, message: Twist, utime: int) -> Mapping[str, Any]:
        return {"utime": utime, "seq": 0, "engaged": message.v_mps == 0.0, "reason": ""}


class Ratio(Adapter):
    """A command that cannot stand still."""

    type_name = "toy.ratio_t"
    lcm_class = graphnav_lcm.twist_t
    message = Twist

    def to_lcm(self, message: Twist, utime: int) -> Mapping[str, Any]:
        return {"utime": utime, "seq": 0, "v_mps": message.v_mps / message.omega_radps, "omega_radps": 1.0}


class Unfinished(Adapter):
    """A command of which something is missing."""

    type_name = "toy.unfinished_t"
    lcm_class = graphnav_lcm.twist_t
    message = Twist

    def to_lcm(self, message: Twist, utime: int) -> Mapping[str, Any]:
        return {"utime": utime, "seq": 0, "v_mps": message.v_mps}


class Odometer(Adapter):
    """A motion as another program tells it."""

    type_name = "toy.odometer_t"
    lcm_class = graphnav_lcm.twist_t
    message = Motion

    def from_lcm(self, fields: Mapping[str, Any]) -> Motion:
        return Motion(forward_m=fields["v_mps"], left_m=0.0, turn_rad=fields["omega_radps"], interval_us=1_000_000)


def _empty(shape: tuple[int, ...]) -> Plane:
    zeros = np.zeros(shape, np.uint8)
    return Plane(
        obstacle=zeros, score=zeros.astype(np.float32), valid=zeros + np.uint8(1), step_px=1, obstacle_ratio=0.0
    )


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [
        Robot, Matcher, Smooth, Mix, Detector, Guess, FromFlows, Taught, Wheels, Guard, Rudder, Score, Helm,
        Idle, Eager, Untyped,
    ]  # fmt: skip


@hookimpl
def graphnav_adapters() -> list[type[Adapter]]:
    return [WheelSpeeds, Ratio, Unfinished, Odometer]
