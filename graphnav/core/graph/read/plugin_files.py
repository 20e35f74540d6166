"""``plugins:`` of a graph: one-file plugins, loaded before anything else of it is checked, if they are trusted."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from graphnav.core.catalog import Catalog
from graphnav.core.errors import CatalogError, Hint, Problem, did_you_mean, one_line, shown_path
from graphnav.core.graph.read.graph_files import GraphFile
from graphnav.core.spec import Value
from graphnav.core.trust import Request, read_plugin

_HINT = "write plugins: [my_stage.py]"


@dataclass(frozen=True)
class PluginFile:
    """A one-file plugin that a graph names."""

    path: Path
    """Absolute."""
    written: str
    """As the graph names it."""


@dataclass(frozen=True)
class Plugins:
    """The one-file plugins of a graph."""

    loaded: tuple[PluginFile, ...]
    """Each once."""
    left_out: tuple[Problem, ...]
    """Those that are not trusted, which did not run."""


def load_plugins(
    files: Sequence[GraphFile], catalog: Catalog, problems: list[Problem], replaced: Collection[str] = ()
) -> Plugins:
    """Add the plugins of a graph's files to the catalog, if they are trusted; what is wrong goes to ``problems``.

    A path is relative to the folder of the file that it is written in, and stays below it, unless the catalog holds the
    file already. Files with a name in ``replaced`` are left out.
    """
    found: dict[Path, PluginFile] = {}
    left_out: list[Problem] = []
    for file in files:
        named: dict[Path, Value] = {}
        for item in _items(file.value, problems):
            path = file.path.parent / str(item.data)
            if path.name in replaced:
                continue
            try:
                named.setdefault(_below(file.path.parent, path, catalog), item)
            except CatalogError as error:
                problems.append(Problem(item.place, error.what, error.hint))
        for plugin in _load(file.path, named, catalog, problems, left_out):
            found.setdefault(plugin.path, plugin)
    return Plugins(tuple(found.values()), tuple(left_out))


def _below(folder: Path, path: Path, catalog: Catalog) -> Path:
    """Return the resolved path of a plugin; raises CatalogError if it is not below the folder of its graph.

    What the command line names may be anywhere.
    """
    try:
        real = path.resolve()
        if catalog.holds_file(path) or real.is_relative_to(folder.resolve()):
            return real
    except (OSError, ValueError, RuntimeError) as error:  # a null character, or a circle of links
        raise CatalogError(f"plugin {path}: {one_line(error)}") from error
    where = str(path) if path == real else f"{path} ({real})"
    raise CatalogError(
        f"plugin {where} is outside of the folder of its graph", "move it there, or name it with --plugin FILE"
    )


def _load(
    graph: Path, named: dict[Path, Value], catalog: Catalog, problems: list[Problem], left_out: list[Problem]
) -> Iterator[PluginFile]:
    """Yield the plugins of one file that could be loaded; the others go to ``problems`` or ``left_out``."""
    sources: dict[Path, bytes] = {}
    for path, item in named.items():
        if catalog.holds_file(path):
            continue
        try:
            sources[path] = read_plugin(path)
        except OSError as error:
            reason: str | None = error.strerror
            hint: Hint = ""
            if isinstance(error, FileNotFoundError):
                reason, hint = "file not found", did_you_mean(path.name, (p.name for p in path.parent.glob("*.py")))
            elif isinstance(error, IsADirectoryError):
                reason, hint = "is not a file", "name a Python file in it"
            problems.append(Problem(item.place, f"plugin {graph.parent / str(item.data)}: {reason}", hint))
    request = Request.of(graph, sources)
    may_run = not sources or catalog.trust.allows(request)
    for path, item in named.items():
        if path in sources and not may_run:
            left_out.append(_left_out(item, request, catalog))
        elif path in sources or catalog.holds_file(path):
            try:
                catalog.add_file(graph.parent / str(item.data), sources.get(path))
            except CatalogError as error:
                problems.append(error.problem(item.place))
            else:
                yield PluginFile(path, str(item.data))


def _left_out(item: Value, request: Request, catalog: Catalog) -> Problem:
    what = f"left out: plugin {item.data}, Python code that is not trusted in {shown_path(request.folder)}"
    return Problem(item.place, what, catalog.trust.advice(request), "untrusted")


def _items(value: Value, problems: list[Problem]) -> Iterator[Value]:
    """Yield the paths under ``plugins``."""
    entry = value.data.get("plugins") if isinstance(value.data, dict) else None
    if entry is None or entry.value.data is None:
        return
    if not isinstance(entry.value.data, list):
        problems.append(Problem(entry.value.place, f"'plugins' must be a list, not {entry.value.kind}", _HINT))
        return
    for item in entry.value.data:
        if isinstance(item.data, str) and item.data:
            yield item
        else:
            problems.append(Problem(item.place, f"'plugins' must list files, but this is {item.kind}", _HINT))
