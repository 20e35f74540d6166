"""Read a graph's file and the files that it extends: one or several, each of which may extend more."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from graphnav.core.errors import Place, Problem, UserError, shown_path
from graphnav.core.graph.find import find_graph
from graphnav.core.spec import Value, parse_yaml, read_bytes

MAX_EXTENDED = 8
"""How many files one graph may extend, one through the other."""
_HINT = "write extends: other.yaml, the name of a graph that ships, or a list: extends: [other.yaml, more.yaml]"


@dataclass(frozen=True)
class GraphFile:
    """One file of a graph, as it was read."""

    value: Value
    path: Path
    source: str
    """The file as places name it."""


@dataclass(frozen=True)
class GraphBytes:
    """The bytes of one file of a graph, before they are parsed."""

    data: bytes
    path: Path
    source: str


def read_files(data: bytes, path: Path, source: str, problems: list[Problem]) -> tuple[GraphFile, ...]:
    """Return the files of a graph, each once: what ``extends`` names first, in its order, the graph's own last.

    ``data``: the bytes of the file ``path``, which errors call ``source``. What is wrong with single values is added to
    ``problems``.

    Raises
    ------
    UserError
        A file is not YAML, or ``extends`` leads nowhere or back to where it began; with all ``problems`` so far.
    """
    try:
        return _read_files(data, path, source, problems)
    except UserError as error:
        raise UserError([*problems, *error.problems]) from error


def _read_files(data: bytes, path: Path, source: str, problems: list[Problem]) -> tuple[GraphFile, ...]:
    files: dict[Path, GraphFile] = {}
    _add(GraphBytes(data, path, source), (path,), files, problems)
    return tuple(files.values())


def _add(graph: GraphBytes, chain: tuple[Path, ...], files: dict[Path, GraphFile], problems: list[Problem]) -> None:
    """Add the files that a graph extends to ``files``, by their resolved paths, then its own.

    A file that is there already stays where it is: what extends it follows it. ``chain``: the files that extend one
    another down to this one.
    """
    value, found = _parsed(graph.data, graph.source)
    problems += found
    for entry, extended in _extended(value, graph.path):
        longer = (*chain, extended)
        _check_chain(longer, entry.place)
        if extended.resolve() not in files:
            source = shown_path(extended)
            _add(GraphBytes(read_bytes(extended, entry.place, source), extended, source), longer, files, problems)
    files[graph.path.resolve()] = GraphFile(value, graph.path, graph.source)


@lru_cache(maxsize=128)
def _parsed(data: bytes, source: str) -> tuple[Value, list[Problem]]:
    """Return what `parse_yaml` does, once for all variants of a graph and all graphs that extend a file."""
    return parse_yaml(data, source)


def _extended(value: Value, path: Path) -> Iterator[tuple[Value, Path]]:
    """Yield the names under ``extends`` of the file ``path``, and the file that each one names."""
    entry = value.data.get("extends") if isinstance(value.data, dict) else None
    if entry is None:
        return
    if not isinstance(entry.value.data, list):
        yield entry.value, _find(entry.value, path)
        return
    if not entry.value.data:
        raise UserError.of("'extends' is an empty list", _HINT, entry.value.place)
    found: set[Path] = set()
    for item in entry.value.data:
        extended = _find(item, path)
        if extended.resolve() in found:
            raise UserError.of(f"'extends' lists '{item.data}' twice", "remove one of them", item.place)
        found.add(extended.resolve())
        yield item, extended


def _find(value: Value, path: Path) -> Path:
    """Return the file that one name under ``extends`` of the file ``path`` names."""
    name = value.data
    if not isinstance(name, str) or not name:
        empty, wrong = (
            "'extends' does not name a graph",
            f"'extends' must be a name or a list of names, not {value.kind}",
        )
        raise UserError.of(empty if name in (None, "") else wrong, _HINT, value.place)
    try:
        return find_graph(name, path.parent)
    except UserError as error:
        raise UserError([Problem(value.place, f"'{name}': {p.what}", p.hint) for p in error.problems]) from error


def _check_chain(paths: Sequence[Path], place: Place) -> None:
    real = [path.resolve() for path in paths]
    if real[-1] in real[:-1]:
        circle = " -> ".join(shown_path(path) for path in paths[real.index(real[-1]) :])
        raise UserError.of(f"'extends' goes in a circle: {circle}", "remove the 'extends' of one of them", place)
    if len(paths) > MAX_EXTENDED + 1:
        what = f"more than {MAX_EXTENDED} files extend one another"
        raise UserError.of(what, "extend a graph nearer to the first", place)
