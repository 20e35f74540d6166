"""Load a graph: find it, read it, swap parts, check everything."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from graphnav.catalog import Catalog
from graphnav.errors import Place, Problem, UserError, shown_path
from graphnav.graph.check import check
from graphnav.graph.find import find_graph
from graphnav.graph.graph import Graph
from graphnav.graph.swap import apply_sets
from graphnav.spec import MAX_BYTES, parse_spec, parse_yaml


def load_graph(path_or_name: str | Path, catalog: Catalog, sets: Sequence[str] = ()) -> Graph:
    """Return the checked graph of a file, or of the name of one in the working folder or among those that ship.

    ``sets`` are swaps as the command line takes them: ``plane=plane.affine``, ``plane.mad_ratio=3``,
    ``plane.in.truth=robot.truth``, ``run.until_s=5``.

    Raises
    ------
    UserError
        Everything that is wrong with the graph and the swaps.
    """
    path = find_graph(path_or_name)
    source = shown_path(path)
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise UserError.of(f"it cannot be read: {error.strerror}", place=Place(source)) from error
    return graph_of(data, path, catalog, sets, source)


def graph_of(data: bytes, path: Path, catalog: Catalog, sets: Sequence[str] = (), source: str = "") -> Graph:
    """Return the checked graph that the bytes of the file ``path`` say; errors name it ``source``.

    Raises
    ------
    UserError
        Everything that is wrong with it.
    """
    value, problems = parse_yaml(data, source or str(path))
    spec, more = parse_spec(value)
    problems += more
    notices: list[str] = []
    spec = apply_sets(spec, sets, catalog, problems, notices)
    graph = check(spec, catalog, path, problems, notices)
    if problems:
        raise UserError(_without_repetitions(problems))
    return graph


def _without_repetitions(problems: list[Problem]) -> list[Problem]:
    return list(dict.fromkeys(problems))
