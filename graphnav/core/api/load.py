"""Load and check graphs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from graphnav.core.api.arguments import Argument, PathLike, plain
from graphnav.core.api.parameters import Shared
from graphnav.core.catalog import Catalog
from graphnav.core.errors import ParamError, Problem, UserError
from graphnav.core.graph import Graph, Override, RunOptions, load_graph
from graphnav.core.parameters import documented
from graphnav.core.stage import params_of
from graphnav.core.trust import Trust


@documented(*Shared.LOADED)
def load(
    graph: PathLike | Graph,
    *,
    set: Mapping[str, object] | None = None,  # noqa: A002 - as --set
    plugins: Sequence[PathLike] = (),
    trust: bool = False,
) -> Graph:
    """Return the checked graph of a file, or of the name of a shipped one.

    Raises
    ------
    UserError
        All errors, with file, line and column: ``error.problems``.
    """
    checked = loaded(graph, set, plugins, Catalog(Trust(runs_all=trust)))
    checked.make_stages()
    return checked


@documented(*Shared.LOADED)
def check(
    graph: PathLike | Graph,
    *,
    set: Mapping[str, object] | None = None,  # noqa: A002 - as --set
    plugins: Sequence[PathLike] = (),
    trust: bool = False,
) -> list[Problem]:
    """Return all errors of a graph, sorted by line; an empty list if there are none.

    ``str(problem)`` is what ``graphnav check`` prints; ``place``, ``what``, ``hint``, ``kind`` and ``suggestion`` are
    its parts.

    Raises
    ------
    UserError
        An argument has a wrong type.
    """
    overrides, files = Argument(set, Shared.SET).overrides(), Argument(plugins, Shared.PLUGINS).paths()
    if isinstance(graph, Graph):
        _refuse_changes(overrides, files)
    name = None if isinstance(graph, Graph) else Argument(graph, Shared.GRAPH).path()
    try:
        found = (
            graph
            if isinstance(graph, Graph)
            else load_with(Catalog(Trust(runs_all=trust)).add_files(files), str(name), overrides, files)
        )
        found.make_stages()
    except UserError as error:
        return list(error.problems)
    return []


def loaded(
    graph: PathLike | Graph,
    sets: Mapping[str, object] | None,
    plugins: Sequence[PathLike],
    catalog: Catalog,
    options: Mapping[str, object] | None = None,
) -> Graph:
    """Return the graph for the arguments of `load`; if it is loaded here, its plugins are added to ``catalog``.

    ``options``: of ``run``, None for those that keep the graph's value.

    Raises
    ------
    UserError
        All errors of the graph.
    """
    overrides, files = Argument(sets, Shared.SET).overrides(), Argument(plugins, Shared.PLUGINS).paths()
    if isinstance(graph, Graph):
        _refuse_changes(overrides, files)
        return with_run_options(graph, options) if options else graph
    name = Argument(graph, Shared.GRAPH).path()
    found = load_with(catalog.add_files(files), str(name), overrides, files)
    return with_run_options(found, options) if options else found


def load_with(
    catalog: Catalog,
    graph: str,
    overrides: Sequence[Override],
    plugins: Sequence[Path],
    problems: Sequence[Problem] = (),
    *,
    partial: bool = False,
    makes_stages: bool = True,
) -> Graph:
    """Return a checked graph; ``catalog`` holds the ``plugins`` already, and the run's folder gets copies of them.

    ``problems``: what is wrong with options that were read before, to be reported with the graph's. ``partial``: as of
    `load_graph`. ``makes_stages``: whether the stages will be made, so that what they miss is reported with the other
    errors.

    Raises
    ------
    UserError
        All errors of the graph.
    """
    found = load_graph(graph, catalog, overrides, problems, partial=partial, makes_stages=makes_stages)
    return replace(found, plugins=tuple(dict.fromkeys((*found.plugins, *(path.resolve() for path in plugins)))))


def _refuse_changes(overrides: Sequence[Override], plugins: Sequence[Path]) -> None:
    if overrides or plugins:
        raise UserError.of("set and plugins have no effect on a loaded graph", "pass them to graphnav.load")


def with_run_options(graph: Graph, options: Mapping[str, object], written: Mapping[str, str] | None = None) -> Graph:
    """Return the graph with other ``run`` options; None keeps the graph's value.

    ``written``: names of options as the user wrote them, if different: ``{"until_s": "--until"}``.

    Raises
    ------
    UserError
        A value has a wrong type or is out of bounds.
    """
    given: dict[str, Any] = {}
    for name, value in options.items():
        if value is not None:
            try:
                given[name] = params_of(RunOptions)[name].parse(plain(value, name))
            except ParamError as error:
                where = f"{written[name]}: " if written and name in written else ""
                raise UserError.of(f"{where}{error.what}", error.hint) from error
    return replace(graph, run=replace(graph.run, **given))
