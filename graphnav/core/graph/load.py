"""Load a graph: find it, read it and what it extends, load its plugins, swap parts, check everything."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
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
from graphnav.core.graph.read.plugin_files import Plugins, load_plugins
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
    found = read_graph(path_or_name, catalog, problems)
    return found.variant(overrides, partial=partial, makes_stages=makes_stages)


def read_graph(path_or_name: str | Path, catalog: Catalog, problems: Sequence[Problem] = ()) -> ReadGraph:
    """Read the file of a graph and those that it extends, for `load_graph` of one or several of its variants.

    Raises
    ------
    UserError
        A file cannot be read, is not YAML or extends nothing that is there, or a plugin cannot be used.
    """
    path = find_graph(path_or_name)
    source = shown_path(path)
    data = read_bytes(path, Place(source))
    return ReadGraph.of(data, path, catalog, source, problems=problems, is_record=is_graph_of_run(path))


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
    prunes: bool = True,
) -> Graph:
    """Return the checked graph in the bytes of the file ``path``; errors name it ``source``.

    ``replaced``, ``is_record``: as of `ReadGraph.of`; ``prunes``: as of `ReadGraph.variant`.

    Raises
    ------
    UserError
        Everything that is wrong with it.
    """
    found = ReadGraph.of(data, path, catalog, source or str(path), replaced, problems, is_record=is_record)
    return found.variant(overrides, prunes=prunes)


@dataclass(frozen=True)
class ReadGraph:
    """A graph's files, read and merged once; what is wrong with them is reported with each variant."""

    path: Path
    catalog: Catalog
    spec: Spec
    plugins: Plugins
    problems: Sequence[Problem]
    file_notices: Sequence[str]

    @classmethod
    def of(
        cls,
        data: bytes,
        path: Path,
        catalog: Catalog,
        source: str,
        replaced: Collection[str] = (),
        problems: Sequence[Problem] = (),
        *,
        is_record: bool = False,
    ) -> ReadGraph:
        """Read the bytes of the file ``path``, which errors name ``source``, and the files that it extends.

        ``replaced``: the file names of plugins that are not loaded, because the catalog holds what takes their place.
        ``is_record``: whether a run wrote it, maybe with an older version: old names of parameters are accepted.

        Raises
        ------
        UserError
            A file cannot be read, is not YAML or extends nothing that is there, or a plugin cannot be used.
        """
        problems, notices = list(problems), list[str]()
        files = read_files(data, path, source, problems)
        unusable: list[Problem] = []
        plugins = load_plugins(files, catalog, unusable, replaced)
        merged = merge_files(files, catalog, problems, notices)
        spec, more = parse_spec(merged.value)
        problems += more + unusable
        if unusable:
            raise UserError(
                _without_repetitions([*problems, *plugins.left_out])
            )  # what their stages lack is not worth telling
        spec.folders = {file.source: file.path.parent for file in files}
        if is_record:
            _accept_old_names(spec, classes_of(spec, catalog, []))
        rewire_merged(spec, merged, catalog, problems, notices)
        return cls(path, catalog, spec, plugins, problems, notices)

    def variant(
        self,
        overrides: Sequence[Override] = (),
        *,
        partial: bool = False,
        makes_stages: bool = False,
        prunes: bool = True,
    ) -> Graph:
        """Return the checked graph with overrides.

        ``partial``: as of `load_graph`. ``makes_stages``: whether a graph with errors gets those of its stages too
        (`Graph.stage_problems`). ``prunes``: whether stages that swaps leave unread are removed.

        Raises
        ------
        UserError
            Everything that is wrong with it.
        """
        problems, notices, left_out = list(self.problems), list[str](), self.plugins.left_out
        spec = apply_overrides(self.spec.copied(), overrides, self.catalog, problems, notices, prunes=prunes)
        graph = check(spec, self.catalog, self.path, problems, notices, left_out)
        if problems or (left_out and not partial):
            more = graph.stage_problems() if makes_stages else []
            raise UserError(_without_repetitions([*problems, *more, *left_out]))
        loaded = self.plugins.loaded
        paths, written = tuple(plugin.path for plugin in loaded), tuple(plugin.written for plugin in loaded)
        return replace(graph, plugins=paths, written_plugins=written, file_notices=tuple(self.file_notices))


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
