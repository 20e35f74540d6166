"""Teach the planar flow of an obstacle-free ground."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from graphnav import Flow, Metric, Motion, ParamError, PlanarModel, Stage, coarsen, param
from graphnav.arrays import Bools, Doubles, Floats
from graphnav_planar.interval import IntervalCheck
from graphnav_planar.normal_equations import NormalEquations
from graphnav_planar.principal_components import Components, principal_components
from graphnav_planar.terms import MEAN, Term, driving_terms, factors, names_of_components

_MAX_FRAMES = 512
_MIN_FRAMES = 64
_MAX_VALUES = 2**24
"""Of all kept flows: 64 MB, unless so few frames of a large picture fit that nothing could be learned from them."""


class Teach(Stage):
    """Planar model of an obstacle-free drive, by least squares.

    For every cell the flow is fitted by a sum of basis fields, each multiplied by a term of the frame's motion:
    ``u = v B_v + w B_w + v w B_vw + w^2 B_ww``, v the forward displacement, w the turn of the frame. It is the series
    expansion of the flow of a plane seen by a driving and turning camera; neither camera nor plane need be known.

    The term "mean" is [OI, eq. 1] itself: the mean flow of the frames that drive straight on, at a displacement within
    ``straight_forward_m``. It is stored in the model beside the other terms but is not part of their sum, so that one
    model serves every planar stage.

    With ``components`` the model also has principal components of what the terms of v and w leave of the flow: the
    flow of a camera that pitches, rolls and bounces while teaching and later, at rates that no odometry knows. A stage
    that uses the model fits their factors to each frame; 4 hold the flow of a camera on a mast that sways.

    Without ``motion`` (a video) every frame counts as straight, and terms of v and w cannot be taught. Components can:
    they are those of the flow itself. A rigid plane seen by a moving camera has a flow of 8 parameters, to first order
    [LP], so 8 components are enough for any motion that was taught, and 4 for a camera that neither pitches, rolls nor
    bounces. `planar.subspace` uses such a model; no odometry is needed from teaching to driving.

    Publishes the current model every ``every_frames`` frames, once the motions seen determine every basis field. A cell
    is valid if it was valid in at least half of the frames. Components are found in at most 512 frames, spread evenly
    over the drive.

    References
    ----------
    .. [OI] N. Ohnishi, A. Imiya, Combination of Supervised and Unsupervised Methods for Navigation Path Mining, eq. 1.
    .. [LP] H. C. Longuet-Higgins, K. Prazdny, The interpretation of a moving retinal image, Proceedings of the Royal
       Society B 208, 1980.
    """

    metrics: ClassVar[tuple[Metric, ...]] = (
        Metric("frames", better="neither", bounds=(0.0, None), help="Frames taught."),
        Metric(
            "residual_px",
            unit="px",
            better="lower",
            bounds=(0.0, None),
            min_difference=0.01,
            help="What the model leaves of the flow, median over the cells.",
        ),
        Metric(
            "turn_span_rad",
            unit="rad",
            better="neither",
            bounds=(0.0, None),
            help="Span of the turns per frame that were taught.",
        ),
        Metric(
            "forward_span_m",
            unit="m",
            better="neither",
            bounds=(0.0, None),
            help="Span of the forward displacements per frame that were taught.",
        ),
    )

    terms: tuple[Term, ...] = param(
        ("mean", "v", "w", "vw", "ww"),
        doc="basis fields to teach: mean, and products of v (forward) and w (turn) up to the second order",
    )
    components: int = param(
        0,
        ge=0,
        le=9,
        doc="principal components to teach of what the terms of v and w leave of the flow, or, without such terms, of "
        "the flow itself; their factors are fitted to each frame. More explain more motions of the camera, and more of "
        "a large obstacle",
    )
    cell_px: int = param(4, ge=1, le=4096, doc="side of the pixel blocks over which the flow is averaged")
    every_frames: int = param(25, ge=1, le=1_000_000, doc="frames between two published models")
    straight_turn_rad: float = param(
        0.01, ge=0.0, le=1000.0, doc="a frame that turns by at most this drives straight on"
    )
    straight_forward_m: tuple[float, float] = param(
        (0.02, 0.04),
        ge=0.0,
        le=100_000.0,
        doc="minimum and maximum displacement per frame that count for the term mean",
    )

    def check(self) -> None:
        """Check that there is something to teach."""
        if not (self.terms or self.components):
            raise ParamError("terms", "no terms and no components: nothing to teach", "write terms: [mean]")

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget everything taught."""
        self._driving = driving_terms(self.terms)
        self._straight = NormalEquations(1, 0, 0)
        self._driven = NormalEquations(0, 0, 0)
        self._kept = KeptFrames()
        self._frames = 0
        self._forward_m = self._turn_rad = np.zeros(2)
        self._model: PlanarModel | None = None
        self._intervals = IntervalCheck()

    def step(self, flow: Flow, motion: Motion | None = None) -> PlanarModel | None:
        """Add a frame, but none whose flow covers several motions, as where a live flow could not follow every image.

        Raises
        ------
        ValueError
            A term needs the motion of this frame, which is missing or covers more than the flow, or less for more
            than 20 flows in a row; or the flow changes its size.
        """
        if motion is None and self._driving:
            wanted = ", ".join(self._driving)
            raise ValueError(
                f"the terms {wanted} need the motion of each frame: wire 'motion', or, without odometry, teach "
                "terms: [mean] with components: 8"
            )
        if motion is not None and not self._intervals.agrees(flow, motion):
            return None
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
        if self.components:
            of_motion = np.zeros(0) if moved is None else factors(self._driving, moved)
            self._kept.add(of_motion, cells.uv_px, valid)

    def _is_straight(self, moved: Motion) -> bool:
        min_m, max_m = self.straight_forward_m
        return abs(moved.turn_rad) <= self.straight_turn_rad and min_m <= moved.forward_m <= max_m

    def _solve(self, interval_us: int) -> PlanarModel | None:
        """Return the current model, None while the frames do not determine all of its fields."""
        valid = self._taught_cells()
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
        if self.components:
            found = self._components(valid)
            if found is None:
                return None
            fields |= zip(self._driving, found.given, strict=True)
            fields |= zip(names_of_components(self.components), found.fields, strict=True)
            residual_px = found.residual
        terms = (*self.terms, *names_of_components(self.components))
        return PlanarModel(
            terms=terms,
            basis=np.stack([fields[term] for term in terms]).astype(np.float32),
            valid=valid.astype(np.uint8),
            residual_px=residual_px.astype(np.float32),
            forward_range_m=self._forward_m,
            turn_range_rad=self._turn_rad,
            frames=self._frames,
            interval_us=interval_us,
            step_px=self.cell_px,
        )

    def _taught_cells(self) -> Bools:
        """Return which cells were valid in at least half of the frames of each part of the model, (rows, cols)."""
        valid = np.ones(self._straight.count.shape, np.bool_)
        for fit, wanted in (
            (self._straight, MEAN in self.terms),
            (self._driven, bool(self._driving)),
            (self._kept, bool(self.components)),
        ):
            if wanted:
                valid &= (2 * fit.count >= fit.count.max()) & (fit.count > 0)
        return valid

    def _components(self, valid: Bools) -> Components | None:
        """Return the fields of the driving terms and the components, on the grid: 0 outside ``valid``."""
        of_motion, uv_px, counted = self._kept.arrays()
        found = principal_components(of_motion, uv_px[:, valid], counted[:, valid], self.components)
        if found is None:
            return None
        given, fields = (np.zeros((len(part), *valid.shape, 2)) for part in found[:2])
        residual = np.zeros(valid.shape)
        given[:, valid], fields[:, valid], residual[valid] = found
        return Components(given, fields, residual)


def _widened(span: Doubles, value: float) -> Doubles:
    return np.array([min(span[0], value), max(span[1], value)])


class KeptFrames:
    """A bounded selection of the frames of a drive, spread evenly over it.

    Every n-th frame; n doubles whenever the frames are too many.
    """

    def __init__(self) -> None:
        self._every = 1
        self._seen = 0
        self._frames: list[tuple[Doubles, Floats, Bools]] = []

    def add(self, factors: Doubles, uv_px: Floats, valid: Bools) -> None:
        """Consider a frame: factors (k,) of its motion, vectors (rows, cols, 2), and the cells whose vector counts."""
        if self._seen % self._every == 0:
            if len(self._frames) >= min(max(_MAX_VALUES // max(uv_px.size, 1), _MIN_FRAMES), _MAX_FRAMES):
                self._frames = self._frames[::2]
                self._every *= 2
            if self._seen % self._every == 0:
                self._frames.append((factors, uv_px.astype(np.float32), valid))
        self._seen += 1

    @property
    def count(self) -> npt.NDArray[np.int64]:
        """Number of kept frames in which each cell is valid, (rows, cols)."""
        return np.asarray(np.sum([valid for _, _, valid in self._frames], axis=0, dtype=np.int64))

    def arrays(self) -> tuple[Doubles, Floats, Bools]:
        """Return the kept factors (frames, k), vectors (frames, rows, cols, 2), and which of them count."""
        factors, uv_px, valid = zip(*self._frames, strict=True)
        return np.array(factors), np.array(uv_px), np.array(valid)
