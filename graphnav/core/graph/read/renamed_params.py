"""Read the graphs of records, logs and run folders, that use names of parameters of older versions."""

from __future__ import annotations

from collections.abc import Mapping

from graphnav.core.spec import Spec
from graphnav.core.stage import Stage, params_of


def accept_old_names(spec: Spec, classes: Mapping[str, type[Stage]]) -> None:
    """Give parameters of ``spec`` that were renamed (`param`'s ``renamed_from``) their present names."""
    for name, cls in classes.items():
        names = {param.renamed_from: param.name for param in params_of(cls).values() if param.renamed_from}
        stage = spec.stages[name]
        stage.params = {names.get(key, key): entry for key, entry in stage.params.items()}
