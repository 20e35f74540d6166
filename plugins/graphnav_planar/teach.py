"""Teach the planar flow of an obstacle-free ground."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from graphnav import Flow, Metric, Motion, PlanarModel, Stage, coarsen, param
from graphnav.arrays import Doubles
from graphnav_planar.interval import check_interval
from graphnav_planar.normal_equations import NormalEquations
from graphnav_planar.terms import MEAN, Term, driving_terms, factors


class Teach(Stage):
    """Planar model of an obstacle-free drive, by least squares.

    For every cell the flow is fitted by a sum of basis fields, each multiplied by a term of the frame's motion:
    ``u = v B_v + w B_w + v w B_vw + w^2 B_ww``, v the forward displacement, w the turn of the frame. It is the series
    expansion of the flow of a plane seen by a driving and turning camera; neither camera nor plane need be known.

    The term "mean" is [OI, eq. 1] itself: the mean flow of the frames that drive straight on, at a displacement within
    ``straight_forward_m``. It is stored in the model beside the other terms but is not part of their sum, so that one
    model serves every planar stage. Without ``motion`` (a video) every frame counts as straight, and only "mean" can be
    taught.

    Publishes the current model every ``every_frames`` frames, once the motions seen determine every basis field. A cell
    is valid if it was valid in at least half of the frames.

    References
    ----------
    .. [OI] N. Ohnishi, A. Imiya, Combination of Supervised and Unsupervised Methods for Navigation Path Mining, eq. 1.
    """

    metrics: ClassVar[tuple[Metric, ...]] = (
        Metric("frames", better="neither", help="Frames taught."),
        Metric(
            "residual_px",
            unit="px",
            better="lower",
            min_difference=0.01,
            help="What the model leaves of the flow, median over the cells.",
        ),
        Metric("turn_span_rad", unit="rad", better="neither", help="Span of the turns per frame that were taught."),
        Metric(
            "forward_span_m",
            unit="m",
            better="neither",
            help="Span of the forward displacements per frame that were taught.",
        ),
    )

    terms: tuple[Term, ...] = param(
        ("mean", "v", "w", "vw", "ww"),
        doc="basis fields to teach: mean, and products of v (forward) and w (turn) up to the second order",
    )
    cell_px: int = param(4, ge=1, doc="side of the pixel blocks over which the flow is averaged")
    every_frames: int = param(25, ge=1, doc="frames between two published models")
    straight_turn_rad: float = param(0.01, ge=0.0, doc="a frame that turns by at most this drives straight on")
    straight_forward_m: tuple[float, float] = param(
        (0.02, 0.04), ge=0.0, doc="minimum and maximum displacement per frame that count for the term mean"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget everything taught."""
        self._driving = driving_terms(self.terms)
        self._straight = NormalEquations(1, 0, 0)
        self._driven = NormalEquations(0, 0, 0)
        self._frames = 0
        self._forward_m = self._turn_rad = np.zeros(2)
        self._model: PlanarModel | None = None

    def step(self, flow: Flow, motion: Motion | None = None) -> PlanarModel | None:
        """Add a frame.

        Raises
        ------
        ValueError
            A term needs the motion of this frame, which is missing or covers another interval than the flow; or the
            flow changes its size.
        """
        if motion is None and self._driving:
            wanted = ", ".join(self._driving)
            raise ValueError(f"the terms {wanted} need the motion of each frame: wire 'motion', or teach only mean")
        if motion is not None:
            check_interval(flow, motion)
        self._add(coarsen(flow, self.cell_px), motion)
        if self._frames % self.every_frames:
            return None
        self._model = self._solve(flow.interval_us)
        return self._model

    def summary(self) -> Mapping[str, float]:
        """Return the frames taught and, of a model, what it leaves and the span of its motion."""
        values = {"frames": float(self._frames)}
        if self._model is not None:
            values["residual_px"] = float(np.median(self._model.residual_px[self._model.valid != 0]))
            values["turn_span_rad"] = float(np.ptp(self._model.turn_range_rad))
            values["forward_span_m"] = float(np.ptp(self._model.forward_range_m))
        return values

    def _add(self, cells: Flow, moved: Motion | None) -> None:
        rows, cols = cells.valid.shape
        if not self._frames:
            self._straight = NormalEquations(1, rows, cols)
            self._driven = NormalEquations(len(self._driving), rows, cols)
        if self._straight.count.shape != (rows, cols):
            was = self._straight.count.shape
            raise ValueError(f"the flow was {was[1]}x{was[0]} cells of {self.cell_px} px, but is {cols}x{rows} now")
        self._frames += 1
        valid = cells.valid != 0
        if moved is None or self._is_straight(moved):
            self._straight.add(np.ones(1), cells.uv_px, valid)
        if moved is not None:
            self._driven.add(factors(self._driving, moved), cells.uv_px, valid)
            self._forward_m = _widened(self._forward_m, moved.forward_m)
            self._turn_rad = _widened(self._turn_rad, moved.turn_rad)

    def _is_straight(self, moved: Motion) -> bool:
        min_m, max_m = self.straight_forward_m
        return abs(moved.turn_rad) <= self.straight_turn_rad and min_m <= moved.forward_m <= max_m

    def _solve(self, interval_us: int) -> PlanarModel | None:
        """Return the current model, None while the frames do not determine all of its fields."""
        valid = np.ones(self._straight.count.shape, np.bool_)
        for fit, wanted in ((self._straight, MEAN in self.terms), (self._driven, bool(self._driving))):
            if wanted:
                valid &= (2 * fit.count >= fit.count.max()) & (fit.count > 0)
        fields: dict[str, Doubles] = {}
        residual_px = np.zeros(valid.shape)
        if MEAN in self.terms:
            mean = self._straight.solve(valid)
            if mean is None:
                return None
            fields[MEAN], residual_px = mean.fields[0], mean.residual
        if self._driving:
            driven = self._driven.solve(valid)
            if driven is None:
                return None
            fields |= zip(self._driving, driven.fields, strict=True)
            residual_px = driven.residual
        return PlanarModel(
            terms=self.terms,
            basis=np.stack([fields[term] for term in self.terms]).astype(np.float32),
            valid=valid.astype(np.uint8),
            residual_px=residual_px.astype(np.float32),
            forward_range_m=self._forward_m,
            turn_range_rad=self._turn_rad,
            frames=self._frames,
            interval_us=interval_us,
            step_px=self.cell_px,
        )


def _widened(span: Doubles, value: float) -> Doubles:
    return np.array([min(span[0], value), max(span[1], value)])
