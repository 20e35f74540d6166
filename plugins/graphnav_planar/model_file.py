"""Planar models as files: an LCM event log with one message."""

from __future__ import annotations

from pathlib import Path

from graphnav import GraphnavError, ParamError, PlanarModel, Recording

TEACH = "teach one: graphnav teach GRAPH, with a graph that ends in planar.teach"


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
