"""Stages of the family ``judge``: what studies of toys compare by."""

from typing import ClassVar

import numpy as np

from graphnav import Flow, Metric, Plane, Role, Stage, hookimpl, param

FAMILY = "judge"


class Blind(Stage):
    """A baseline: it sees no obstacle."""

    role: ClassVar[Role] = "baseline"

    def step(self, flow: Flow) -> Plane:
        zeros = np.zeros(flow.valid.shape, np.uint8)
        return Plane(
            obstacle=zeros, score=zeros.astype(np.float32), valid=zeros + np.uint8(1), step_px=1, obstacle_ratio=0.0
        )


class Oracle(Blind):
    """An oracle that happens to see nothing."""

    role: ClassVar[Role] = "oracle"


class Score(Stage):
    """Two metrics of a plane."""

    metrics: ClassVar[tuple[Metric, ...]] = (
        Metric("right", better="higher", help="What is right."),
        Metric("wrong", better="lower", help="What is wrong."),
    )
    weight: float = param(1.0, ge=0.0, doc="of everything")

    def reset(self, seed: int) -> None:
        self._planes = 0

    def step(self, plane: Plane) -> None:
        self._planes += 1

    def summary(self) -> dict[str, float]:
        return {"right": self.weight * self._planes, "wrong": 0.0}


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Blind, Oracle, Score]
