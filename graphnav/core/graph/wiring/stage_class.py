"""The class of a stage, with the ports that its parameters declare."""

from __future__ import annotations

from pathlib import Path

from graphnav.core.catalog import Catalog
from graphnav.core.errors import ParamError, Problem
from graphnav.core.graph.wiring.settings import param_problem, settings_of
from graphnav.core.spec import StageSpec
from graphnav.core.stage import Stage


def stage_class(stage: StageSpec, catalog: Catalog, problems: list[Problem]) -> type[Stage] | None:
    """Return the class of a stage; None if its parameters do not declare the ports, which is added to ``problems``.

    Raises
    ------
    CatalogError
        The catalog does not have it, or its plugin cannot be used.
    """
    cls = catalog.stage(stage.use)
    if not cls.ports_from:
        return cls
    catalog.load_types()  # ports may be of any message
    found: list[Problem] = []
    settings = settings_of(stage, cls, Path(), found)
    if not settings.keys() >= {*cls.ports_from}:
        problems += found
        return None
    try:  # what else is wrong is told where all parameters are checked
        return catalog.stage_with_ports(stage.use, {name: settings[name].value for name in cls.ports_from})
    except ParamError as error:
        problems.append(param_problem(stage, settings, error))
    except ExceptionGroup as group:
        problems += [param_problem(stage, settings, e) for e in group.exceptions if isinstance(e, ParamError)]
    return None
