"""Base of the stages that use a taught planar model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from graphnav import Flow, ParamError, Planar, PlanarModel, Stage, param
from graphnav.arrays import Doubles
from graphnav_planar.model_file import TEACH, read_model


class Taught(Stage):
    """A stage with a taught planar model."""

    model: Path = param(doc="planar model, as saved by graphnav teach")

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Read the model."""
        self._use(read_model(self.model))

    def check(self) -> None:
        """Check that the model can be read and has the terms that this stage needs."""
        self.reset(0)

    def _use(self, model: PlanarModel) -> None:
        """Store the parts of the model that `step` needs.

        Raises
        ------
        ParamError
            The model does not have them.
        """
        raise NotImplementedError

    def _not_taught(self, what: str, model: PlanarModel) -> ParamError:
        return ParamError("model", f"{self.model} was not taught {what}: its terms are {', '.join(model.terms)}", TEACH)


def check_size(model: PlanarModel, flow: Flow) -> None:
    """Check that the flow has the taught image size.

    Raises
    ------
    ValueError
        It has not.
    """
    rows, cols = model.valid.shape
    flow_rows, flow_cols = flow.valid.shape
    if (rows, cols) != tuple(-(-size * flow.step_px // model.step_px) for size in (flow_rows, flow_cols)):
        raise ValueError(
            f"the planar model is {cols}x{rows} cells of {model.step_px} px, "
            f"but the flow is {flow_cols}x{flow_rows} cells of {flow.step_px} px; {TEACH}"
        )


def planar(model: PlanarModel, uv_px: npt.NDArray[np.floating], interval_us: int) -> Planar:
    """Return the planar flow ``uv_px``, (rows, cols, 2) on the model's grid, as a message."""
    return Planar(
        planar_uv_px=uv_px.astype(np.float32),
        planar_valid=model.valid,
        residual_px=model.residual_px,
        interval_us=interval_us,
        step_px=model.step_px,
    )


def stacked(cells: Flow, model: PlanarModel) -> tuple[npt.NDArray[np.intp], Doubles]:
    """Return the indices of the valid vectors in a flattened field (2, rows, cols), (2n,), and their values, (2n,).

    Horizontal parts first, then the vertical ones. ``cells``: a flow on the model's grid.
    """
    both = np.flatnonzero(np.tile(((cells.valid & model.valid) != 0).reshape(-1), 2))
    return both, cells.uv_px.transpose(2, 0, 1).reshape(-1)[both].astype(np.float64)
