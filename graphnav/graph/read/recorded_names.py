"""Read the parameter names of graphs that earlier versions recorded."""

from __future__ import annotations

from graphnav.spec import Spec
from graphnav.stage import former_names


def rename_parameters(spec: Spec) -> None:
    """Call the parameters of a recorded graph what they are called now."""
    for stage in spec.stages.values():
        renamed = former_names.PARAMETERS.get(stage.use, {})
        stage.params = {renamed.get(name, name): entry for name, entry in stage.params.items()}
