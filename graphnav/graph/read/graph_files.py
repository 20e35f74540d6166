"""Read a graph's file and the files that it extends."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from graphnav.errors import Place, Problem, UserError, shown_path
from graphnav.graph.find import find_graph
from graphnav.spec import Entry, Value, parse_yaml, read_bytes

MAX_EXTENDED = 8
"""How many files one graph may extend, one through the other."""
_HINT = "write extends: other.yaml, or the name of a graph that ships"


@dataclass(frozen=True)
class GraphFile:
    """One file of a graph, as it was read."""

    value: Value
    path: Path
    source: str
    """The file as places name it."""


def read_files(data: bytes, path: Path, source: str, problems: list[Problem]) -> tuple[GraphFile, ...]:
    """Return the files of a graph: what ``extends`` names first, the graph's own last.

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
    files: list[GraphFile] = []
    while True:
        value, found = parse_yaml(data, source)
        problems += found
        files.append(GraphFile(value, path, source))
        entry = _extends(value)
        if entry is None:
            return tuple(reversed(files))
        path = _extended(entry.value, path)
        _check_chain([*(file.path for file in files), path], entry.value.place)
        source = shown_path(path)
        data = read_bytes(path, entry.value.place, source)


def _extends(value: Value) -> Entry | None:
    return value.data.get("extends") if isinstance(value.data, dict) else None


def _extended(value: Value, path: Path) -> Path:
    """Return the file that ``extends`` of the file ``path`` names."""
    name = value.data
    if not isinstance(name, str) or not name:
        what = (
            "'extends' does not name a graph" if name in (None, "") else f"'extends' must be a name, not {value.kind}"
        )
        raise UserError.of(what, _HINT, value.place)
    try:
        return find_graph(name, path.parent)
    except UserError as error:
        raise UserError([Problem(value.place, f"'{name}': {p.what}", p.hint) for p in error.problems]) from error


def _check_chain(paths: list[Path], place: Place) -> None:
    real = [path.resolve() for path in paths]
    if real[-1] in real[:-1]:
        circle = " -> ".join(shown_path(path) for path in paths[real.index(real[-1]) :])
        raise UserError.of(f"'extends' goes in a circle: {circle}", "remove the 'extends' of one of them", place)
    if len(paths) > MAX_EXTENDED + 1:
        what = f"more than {MAX_EXTENDED} files extend one another"
        raise UserError.of(what, "extend a graph nearer to the first", place)
