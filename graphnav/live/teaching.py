"""Teaching a planar model: the motions that a run drove, those that are missing, and the progress it shows."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from rich.text import Text

from graphnav import About, Flow, Graph, Motion, PlanarModel
from graphnav.arrays import Doubles
from graphnav.core.codec import decode
from graphnav.core.machine import Console

NEAR_RATIO = 0.8
"""A motion of at least this share of a limit counts as near it."""
MIN_FRAMES = 10
"""Frames near each limit: fewer may be errors of the odometry."""
SETTLED_RATIO = 0.05
"""Largest change of the residual between two models that are alike."""
MIN_SPEED_MPS = 0.02
"""A slower robot stands."""
MIN_SPAN_MPS = 0.05
"""Speeds within less of each other count as one."""
MIN_TURN_RADPS = 0.1
"""A slower turn counts as driving straight on."""
LINE_S = 10.0
"""Time between two lines without a terminal."""


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


class Coverage(NamedTuple):
    """Motions to teach: speeds up to ``speed_mps``, turning rates up to ``turn_radps`` to each side."""

    speed_mps: float
    turn_radps: float

    def is_reached(self, taught: Taught) -> bool:
        """Whether the motions that the newest model was made of reach each limit, and it is like the one before it.

        At least 10 frames must be near a limit.
        """
        speeds, turns = taught.learnt_rates.T
        for values, limit in ((speeds, self.speed_mps), (turns, self.turn_radps), (-turns, self.turn_radps)):
            near = np.count_nonzero(values >= NEAR_RATIO * limit)
            if near < MIN_FRAMES or values.max() < limit:
                return False
        last = taught.residuals_px[-2:]
        return len(last) == 2 and abs(last[1] - last[0]) <= SETTLED_RATIO * last[0]


def gaps(taught: Taught) -> list[str]:
    """Return the motions that were not driven, a sentence each."""
    rates = taught.rates
    if not taught.needs_motion or not len(rates):
        return []
    speeds, turns = rates.T
    if abs(rates).max() < MIN_SPEED_MPS:
        return ["the robot stood still"]
    missing = []
    if speeds.max() < MIN_SPEED_MPS:
        missing.append("the robot never drove forward")
    elif speeds.max() - speeds.min() < MIN_SPAN_MPS:
        missing.append(f"the speed did not vary: {speeds.min():.2f} to {speeds.max():.2f} m/s")
    sides = [name for name, max_radps in (("left", turns.max()), ("right", -turns.min())) if max_radps < MIN_TURN_RADPS]
    if len(sides) == 2:
        missing.append("no turn was driven")
    elif sides:
        missing.append(f"no turn to the {sides[0]} was driven")
    return missing


def why_no_model(taught: Taught, inputs: Sequence[Mapping[str, Any]]) -> str:
    """Return the hint for a run without a model; ``inputs``: of a live run, their status at its end."""
    for one in inputs:
        if not one["accepted"]:
            rejected = zip(one["reasons"], one["rejected"], one["details"], strict=True)
            counts = [
                f"{count} {reason}{' (' * bool(told)}{told}{')' * bool(told)}" for reason, count, told in rejected
            ]
            if counts:
                return f"no message on {one['channel']} could be used: {', '.join(counts)}; correct its sender"
            return f"no message on {one['channel']}: start its sender, or give its URL with --url"
    if not taught.flows:
        return "no flow was computed: it needs two pictures or more; run it longer with --until"
    if taught.needs_motion and not len(taught.rates):
        return "no motion of a frame is known: give odometry whose stamps cover those of the pictures"
    missing = gaps(taught)
    if missing:
        return f"{'; '.join(missing)}; teach for longer, at several speeds, turning to both sides"
    return (
        f"{taught.flows} frames did not determine it: teach for longer, at several speeds, turning to both sides; "
        "the term mean also needs frames straight on, within the teacher's straight_forward_m"
    )


@contextmanager
def teaching_progress(console: Console, taught: Taught) -> Iterator[Callable[[float], None]]:
    """Yield a function that shows the progress at a time of the run in seconds."""
    if console.is_terminal:
        with console.status("") as status:
            yield lambda run_s: status.update(Text(progress_line(taught, run_s)))
        return
    shown_s = 0.0

    def show(run_s: float) -> None:
        nonlocal shown_s
        if run_s >= shown_s + LINE_S:
            shown_s = run_s
            console.print(progress_line(taught, run_s), markup=False)

    yield show


def progress_line(taught: Taught, run_s: float) -> str:
    """Return frames, spans of speed and turning rate, and the residual of the newest model, or what is missing."""
    parts = [f"{run_s:.0f} s", f"{taught.flows} frames"]
    if len(rates := taught.rates):
        (v_low, w_low), (v_high, w_high) = rates.min(axis=0), rates.max(axis=0)
        parts += [f"v {v_low:.2f} to {v_high:.2f} m/s", f"omega {w_low:.2f} to {w_high:.2f} rad/s"]
    residual = f"residual {taught.residuals_px[-1]:.3f} px" if taught.residuals_px else "no model yet"
    return ", ".join([*parts, residual, *gaps(taught)])
