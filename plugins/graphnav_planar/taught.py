"""Base of the stages that use a taught planar model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from graphnav import Flow, GraphnavError, ParamError, Planar, PlanarModel, Recording, Stage, param
from graphnav.arrays import Bools, Floats

TEACH = "teach one: graphnav teach GRAPH, with a graph that ends in planar.teach"


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
    """Return the planar flow ``uv_px`` on the model's grid, (rows, cols, 2) or (2n,), as a message."""
    return Planar(
        planar_uv_px=np.ascontiguousarray(uv_px, np.float32).reshape(*model.valid.shape, 2),
        planar_valid=model.valid,
        residual_px=model.residual_px,
        interval_us=interval_us,
        step_px=model.step_px,
    )


def vectors(cells: Flow, model: PlanarModel) -> tuple[Floats, Bools]:
    """Return the vectors of a flow on the model's grid, (2n,): u and v of each in turn; and which of them count, (n,).

    A vector counts if it is valid and was taught.
    """
    return cells.uv_px.reshape(-1), ((cells.valid & model.valid) != 0).reshape(-1)


def read_model(path: Path) -> PlanarModel:
    """Return the last planar model in the log at ``path``.

    Raises
    ------
    ParamError
        The file does not exist, is not a log, or does not contain a planar model; names the parameter 'model'.
    """
    try:
        with Recording(path) as log:
            for channel, kind in log.channels.items():
                if kind is PlanarModel.lcm_class:
                    message = log.message(channel, -1)[2]
                    assert isinstance(message, PlanarModel)
                    return message
    except GraphnavError as error:
        raise ParamError("model", str(error), TEACH) from error
    raise ParamError("model", f"{path} holds no planar model", TEACH)
