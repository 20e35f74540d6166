"""Planar flow for the motion estimated from the flow itself, without odometry."""

from __future__ import annotations

import numpy as np

from graphnav import Continuity, Flow, ParamError, Planar, PlanarModel, Stamp, param
from graphnav.arrays import Bools, Doubles
from graphnav_planar.estimation.egomotion import best_motion, fitted_motion, motions_of_subsets
from graphnav_planar.estimation.robust import NOISE_DOC, NOISE_PX
from graphnav_planar.estimation.series import Series
from graphnav_planar.fitted import fitted
from graphnav_planar.taught import Taught
from graphnav_planar.terms import driving_terms, free_terms, orders


class Subspace(Taught):
    """Planar flow for the current motion, estimated from the flow.

    The flows of an obstacle-free ground form a subspace of all flows, spanned by the basis that `planar.teach` fitted;
    the one with which most of the picture agrees is that of the ground. The factors of the basis are not free: forward
    displacement and turn determine all of them. So two numbers are fitted, by reweighted least squares in which
    obstacles do not count (Geman and McClure's estimator).

    A model may also have principal components (``components`` of `planar.teach`), whose factors are free: beside v and
    w the flow of a camera that shakes, or, taught without odometry, all of the flow. They are fitted along. The more
    unknowns, the fewer random subsets of vectors are free of obstacles, so that fit begins with a noise of 16 times
    ``noise_px`` and narrows it down [BZ].

    That fit ends near where it starts. It starts from the best of these: the last frame's motion (standing still after
    a gap of more than 3 periods), the same without its turn, and the motions that explain random subsets of as many
    vectors as there are unknowns [FB].
    So the ground need only be the largest part of the picture that moves as one plane. With fewer than 6 valid vectors
    there is nothing to fit, and no cell of the planar flow is valid.

    References
    ----------
    .. [FB] M. A. Fischler, R. C. Bolles, Random sample consensus, Communications of the ACM 24(6), 1981.
    .. [BZ] A. Blake, A. Zisserman, Visual Reconstruction, MIT Press, 1987 (graduated non-convexity).
    """

    noise_px: float = param(NOISE_PX, gt=0.0, le=100_000.0, doc=NOISE_DOC)
    draws: int = param(
        16, ge=0, le=1000, doc="random subsets of vectors whose motions the fit may start from; 0 trusts the last frame"
    )
    with_turn: bool = param(
        True,
        doc="whether the planar flow includes that of the turn; false: that of the translation alone, whose mean "
        "points against the way that the robot drives (for the guiding force of `steer.pca`)",
    )

    def reset(self, seed: int) -> None:
        """Read the model and stand still."""
        super().reset(seed)
        self._rng = np.random.default_rng(seed)
        self._motion = np.zeros(self._series.unknowns)
        self._continuity = Continuity()

    def step(self, flow: Flow, stamp: Stamp) -> Planar:
        """Return the planar flow of the motion that ``flow`` shows, for its grid.

        Raises
        ------
        ValueError
            The flow is of another image size than the model.
        """
        if self._continuity.breaks(stamp):
            self._motion = np.zeros(self._series.unknowns)
        return fitted(self._model, flow, self._moved)

    def _moved(self, uv_px: Doubles, counts: Bools) -> Doubles:
        """Estimate the motion; return its planar flow, (2n,), without that of the turn where it is not wanted."""
        series, seen = self._series, np.flatnonzero(counts)
        products = series.products(uv_px)
        starts = np.zeros((series.unknowns, 2 + self.draws))
        starts[:, 0] = self._motion
        if series.n_driving:
            starts[0, 1] = self._motion[0]
        if self.draws:
            starts[:, 2:] = motions_of_subsets(series, products, seen, self.draws, self._rng)
        start = best_motion(series, products, seen, starts, self.noise_px)
        self._motion = fitted_motion(series, products, counts.astype(np.float64), start, self.noise_px)
        if self.with_turn:
            return series.flow(self._motion)
        return series.flow(np.eye(series.unknowns)[0] * self._motion)

    def _use(self, model: PlanarModel) -> None:
        driving, free = driving_terms(model.terms), free_terms(model.terms)
        if not ({"v", "w"} <= set(driving) or (free and not driving)):
            raise self._not_taught("how the flow depends on the motion", model)
        if not (driving or self.with_turn):
            raise ParamError(
                "with_turn",
                f"{self.model} was taught without odometry: its components do not separate turn and translation",
                "write with_turn: true, or teach a model with odometry: wire 'motion' of planar.teach",
            )
        terms = driving + free
        fields = model.basis[[model.terms.index(term) for term in terms]]
        self._series = Series(fields.reshape(len(terms), -1).astype(np.float64), orders(driving))
        self._model = model
