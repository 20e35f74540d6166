"""Planar models as files: an LCM event log with one message."""

from __future__ import annotations

from pathlib import Path

from graphnav import PlanarModel

TEACH = "teach one: graphnav teach GRAPH, with a graph that ends in planar.teach"


def read_model(path: Path) -> PlanarModel:
    """Return the last planar model in the log at ``path``.

    Raises
    ------
    ParamError
        There is no such file, it is no log, or it holds no planar model; of the parameter 'model'.
    """
    raise NotImplementedError(path)
