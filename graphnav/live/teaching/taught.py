"""Follow a run that teaches: its motions and its newest planar model."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from graphnav import About, Flow, Graph, Motion, PlanarModel
from graphnav.arrays import Doubles
from graphnav.core.codec import decode


class Taught:
    """A sink of a run that keeps what its teacher receives and publishes.

    ``channel``: that of the planar model. ``model``: the newest one, None before the first. ``residuals_px``: median
    over the valid cells of each model's residual, oldest first. ``flows``: number of flows that the teacher was sent.
    """

    url = "memq://"
    dropped = 0

    def __init__(self, graph: Graph, channel: str) -> None:
        self.model: PlanarModel | None = None
        self.flows = 0
        self._channel = channel
        (teacher,) = (node for node in graph.nodes if channel in {one.name for one in node.outputs.values()})
        inputs = {one.channel.name: one.channel.message for one in teacher.inputs if one.channel is not None}
        self._flows = {name for name, message in inputs.items() if message is Flow}
        self._motions = {name for name, message in inputs.items() if message is Motion}
        self._rates: list[tuple[float, float]] = []
        self._n_learnt = 0
        self.residuals_px: list[float] = []

    @property
    def needs_motion(self) -> bool:
        """Whether the teacher reads motions."""
        return bool(self._motions)

    @property
    def rates(self) -> Doubles:
        """Speed in m/s and turning rate in rad/s of every motion, (n, 2)."""
        return np.array(self._rates, np.float64).reshape(-1, 2)

    @property
    def learnt_rates(self) -> Doubles:
        """The same of the motions before the newest model, which holds for no others, (n, 2)."""
        return self.rates[: self._n_learnt]

    def write(self, channel: str, utime: int, data: bytes) -> None:  # noqa: ARG002
        """Take a message of the run."""
        if channel in self._flows:
            self.flows += 1
        elif channel in self._motions:
            _, _, motion = decode(Motion, data)
            if motion.interval_us > 0:
                period_s = motion.interval_us * 1e-6
                self._rates.append((motion.forward_m / period_s, motion.turn_rad / period_s))
        elif channel == self._channel:
            _, _, model = decode(PlanarModel, data)
            valid = model.valid != 0
            self.model, self._n_learnt = model, len(self._rates)
            self.residuals_px.append(float(np.median(model.residual_px[valid])) if valid.any() else np.inf)

    def announce(self, about: About, shareable: Collection[str] = ()) -> None:
        """Do nothing: the graph is known."""

    def close(self) -> None:
        """Do nothing: what was taught stays."""
