"""A stage whose defaults do not fit their own declarations."""

from pathlib import Path
from typing import Literal

from graphnav import Flow, Image, Stage, hookimpl, param

FAMILY = "defaults"


class Wrong(Stage):
    """Flow of an image, with defaults that a graph could not write."""

    layers: int = param(0, ge=1, le=8, doc="layers of the pyramid")
    rule: Literal["mad", "otsu"] = param("otso", doc="how the threshold is found")
    share: float = param(float("nan"), doc="share of the ground, dimensionless")
    limits: tuple[float, float] = param((0.0,), doc="least and greatest threshold")
    model: Path = param("", doc="a planar model")
    given: int = param(-1, ge=0, doc="as wrong, but the graph gives another value")

    def step(self, image: Image) -> Flow | None:
        return None


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Wrong]
