"""Load a graph: find it, read it and what it extends, load its plugins, swap parts, check everything."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Place, Problem, UserError, shown_path
from graphnav.core.graph.check import check, classes_of
from graphnav.core.graph.find import find_graph
from graphnav.core.graph.graph import Graph
from graphnav.core.graph.overrides.override import Override
from graphnav.core.graph.overrides.swap import apply_overrides
from graphnav.core.graph.read.extend import merge_files, rewire_merged
from graphnav.core.graph.read.graph_files import read_files
from graphnav.core.graph.read.plugin_files import load_plugins
from graphnav.core.run_folder import is_graph_of_run
from graphnav.core.spec import Spec, outline, parse_spec, read_bytes
from graphnav.core.stage import Stage, params_of


def load_graph(
    path_or_name: str | Path,
    catalog: Catalog,
    overrides: Sequence[Override] = (),
    problems: Sequence[Problem] = (),
    *,
    partial: bool = False,
    makes_stages: bool = False,
) -> Graph:
    """Return the checked graph of a file, or of the name of one in the working folder or among those that ship.

    ``problems``: what is wrong with options that were read before, to be reported with the graph's. ``partial``:
    plugins that are not trusted are not an error; the graph says what it lacks (`Graph.left_out`), and cannot run.
    ``makes_stages``: whether its stages will be made, so that a missing file is reported with the other errors.

    Raises
    ------
    UserError
        Everything that is wrong with the graph and the overrides.
    """
    path = find_graph(path_or_name)
    source = shown_path(path)
    data, is_record = read_bytes(path, Place(source)), is_graph_of_run(path)
    return graph_of(
        data,
        path,
        catalog,
        overrides,
        source,
        problems=problems,
        is_record=is_record,
        partial=partial,
        makes_stages=makes_stages,
    )


def graph_of(
    data: bytes,
    path: Path,
    catalog: Catalog,
    overrides: Sequence[Override] = (),
    source: str = "",
    replaced: Collection[str] = (),
    problems: Sequence[Problem] = (),
    *,
    is_record: bool = False,
    partial: bool = False,
    makes_stages: bool = False,
    prunes: bool = True,
) -> Graph:
    """Return the checked graph in the bytes of the file ``path``; errors name it ``source``.

    ``replaced``: the file names of plugins that are not loaded, because the catalog holds what takes their place.
    ``is_record``: whether a run wrote it, maybe with an older version: old names of parameters are accepted.
    ``partial``: as of `load_graph`. ``makes_stages``: whether a graph with errors gets those of its stages too
    (`Graph.stage_problems`). ``prunes``: whether stages that swaps leave unread are removed.

    Raises
    ------
    UserError
        Everything that is wrong with it.
    """
    problems, notices, file_notices = list(problems), list[str](), list[str]()
    files = read_files(data, path, source or str(path), problems)
    unusable: list[Problem] = []
    plugins = load_plugins(files, catalog, unusable, replaced)
    merged = merge_files(files, catalog, problems, file_notices)
    spec, more = parse_spec(merged.value)
    problems += more + unusable
    if unusable:
        raise UserError(
            _without_repetitions([*problems, *plugins.left_out])
        )  # what their stages lack is not worth telling
    spec.folders = {file.source: file.path.parent for file in files}
    if is_record:
        _accept_old_names(spec, classes_of(spec, catalog, []))
    rewire_merged(spec, merged, catalog, problems, file_notices)
    spec = apply_overrides(spec, overrides, catalog, problems, notices, prunes=prunes)
    graph = check(spec, catalog, path, problems, notices, plugins.left_out)
    if problems or (plugins.left_out and not partial):
        more = graph.stage_problems() if makes_stages else []
        raise UserError(_without_repetitions([*problems, *more, *plugins.left_out]))
    paths, written = tuple(plugin.path for plugin in plugins.loaded), tuple(p.written for p in plugins.loaded)
    return replace(graph, plugins=paths, written_plugins=written, file_notices=tuple(file_notices))


def outline_of_file(path: Path) -> Spec:
    """Return what a graph's file and those that it extends say, as far as it can be read.

    Nothing is checked, no plugin runs and no stage is imported, so that a swapped stage keeps all of its words.

    Raises
    ------
    UserError
        A file cannot be read or is not YAML, or `extends` names none.
    """
    source = shown_path(path)
    files = read_files(read_bytes(path, Place(source)), path, source, [])
    return outline(merge_files(files, None, [], []).value)


def _without_repetitions(problems: list[Problem]) -> list[Problem]:
    return list(dict.fromkeys(problems))


def _accept_old_names(spec: Spec, classes: Mapping[str, type[Stage]]) -> None:
    """Give parameters of ``spec`` that were renamed (`param`'s ``renamed_from``) their present names."""
    for name, cls in classes.items():
        names = {param.renamed_from: param.name for param in params_of(cls).values() if param.renamed_from}
        stage = spec.stages[name]
        stage.params = {names.get(key, key): entry for key, entry in stage.params.items()}
