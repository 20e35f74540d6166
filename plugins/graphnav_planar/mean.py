"""Planar flow as the mean of an obstacle-free drive."""

from __future__ import annotations

from graphnav import Flow, Planar, PlanarModel
from graphnav_planar.taught import Taught, check_size, planar
from graphnav_planar.terms import MEAN


class Mean(Taught):
    """Planar flow of [OI, eq. 1]: the mean flow of driving straight over free ground, the same in every frame.

    Valid only while the robot drives straight on at about the taught speed: in a turn the entire floor differs from it.
    It is scaled by the ratio of the flow's interval to the taught one.

    References
    ----------
    .. [OI] N. Ohnishi, A. Imiya, Combination of Supervised and Unsupervised Methods for Navigation Path Mining, eq. 1.
    """

    def step(self, flow: Flow) -> Planar:
        """Return the mean for the grid of ``flow``.

        Raises
        ------
        ValueError
            The flow is of another image size than the model.
        """
        check_size(self._model, flow)
        return planar(self._model, self._mean_px * (flow.interval_us / self._model.interval_us), flow.interval_us)

    def _use(self, model: PlanarModel) -> None:
        if MEAN not in model.terms:
            raise self._not_taught("the mean flow of driving straight", model)
        self._model = model
        self._mean_px = model.basis[model.terms.index(MEAN)]
