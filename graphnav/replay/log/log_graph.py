"""Which graph made a log, and with which seed."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path, PurePath
from typing import Any

from graphnav.catalog import Catalog
from graphnav.codec import DecodeError, decode
from graphnav.errors import Place, Problem, UserError, shown_path
from graphnav.graph import Graph, graph_of, load_graph
from graphnav.messages import About
from graphnav.record import ABOUT, LOG, Recording
from graphnav.run_folder import GRAPH
from graphnav.runner.lockstep_status import STATUS
from graphnav.spec import parse_yaml

_SEED = "run.seed"


@dataclass(frozen=True)
class LogGraph:
    """The graph that a replay steps, and what the log says of itself, None where it says nothing."""

    graph: Graph
    about: About | None
    is_small: bool
    """Whether the log keeps small messages only."""
    is_live: bool
    """Whether it is the log of a live run."""
    wires: Mapping[str, Mapping[str, str]]
    """What the inputs of each stage of that run read, by the names of stage and port."""


def about_in(recording: Recording) -> About | None:
    """Return what a log says of itself; a log of the tap says it now and then, not in its first event."""
    for index in range(recording.count(ABOUT)):
        try:
            return decode(About, recording.event(ABOUT, index).data)[2]
        except DecodeError:
            continue
    return None


def graph_to_replay(
    recording: Recording,
    catalog: Catalog,
    *,
    graph: str | Path | None = None,
    sets: Sequence[str] = (),
    plugins: Sequence[Path] = (),
) -> LogGraph:
    """Return the graph of a log with ``sets`` applied, or the one that ``graph`` names, with the seed of the log.

    The graph of a run folder is loaded from the ``graph.yaml`` in it, with the plugins that the folder holds; any
    other log loads no plugin by itself. ``plugins`` were added to the catalog already, and take the place of those of
    the same file name.

    Raises
    ------
    UserError
        The log does not say which graph made it, or everything that is wrong with the graph.
    """
    about = about_in(recording)
    if graph is not None:
        found = load_graph(graph, catalog, sets)
    else:
        with _printable_errors():
            found = _own_graph(recording, about, catalog, sets, {path.name for path in plugins})
    return _log_graph(_with_seed(found, about, sets), about)


def _own_graph(
    recording: Recording, about: About | None, catalog: Catalog, sets: Sequence[str], given: Collection[str]
) -> Graph:
    """Return the graph of a run folder, else the one that the log says; ``given``: names of plugins that are loaded."""
    saved = recording.path.parent / GRAPH
    if recording.path.name == LOG and saved.is_file() and _is_of_log(saved.read_bytes(), about):
        source = shown_path(saved)
        return graph_of(saved.read_bytes(), saved, catalog, sets, source, given, is_record=True)
    source = shown_path(recording.path)
    if about is None:
        what = f"{source} does not say which graph made it: it holds no readable '{ABOUT}'"
        raise UserError.of(what, "name the graph with --graph FILE")
    source = f"{source} ({ABOUT})"
    data = _yaml_of(about)
    plain = parse_yaml(data, source)[0].plain()
    words = plain if isinstance(plain, dict) else {}
    if "extends" in words:
        what = "the graph of this log extends another one, which no run says of itself"
        raise UserError.of(what, "name the graph with --graph FILE", Place(source))
    listed = words.get("plugins")
    named = [PurePath(str(item)).name for item in listed] if isinstance(listed, list) else []
    absent = [name for name in named if name not in given]
    if absent:
        what = f"the graph of this log needs the plugin '{absent[0]}'"
        raise UserError.of(what, "name the file with --plugin FILE", Place(source))
    return graph_of(data, recording.path, catalog, sets, source, named, is_record=True)


def _log_graph(graph: Graph, about: About | None) -> LogGraph:
    if about is None:
        return LogGraph(graph, about, is_small=False, is_live=False, wires={})
    is_live = STATUS in about.channels
    record = _section(_yaml_of(about), "run").get("record") or ("small" if is_live else "all")
    stages = _section(_yaml_of(about), "stages").items()
    wires = {name: _mapping(stage.get("in")) for name, stage in stages if isinstance(stage, dict)}
    return LogGraph(graph, about, record == "small", is_live, wires)


@contextmanager
def _printable_errors() -> Iterator[None]:
    """Let what is wrong with a graph that came from elsewhere hold nothing that a terminal obeys."""
    try:
        yield
    except UserError as error:
        problems = [Problem(p.place, _printable(p.what), _printable(p.hint)) for p in error.problems]
        raise UserError(problems) from error


def _with_seed(graph: Graph, about: About | None, sets: Sequence[str]) -> Graph:
    """Return a graph with the seed of the log, unless ``--set`` gives another one."""
    is_given = any(text.partition("=")[0].strip() == _SEED for text in sets)
    if about is None or is_given:
        return graph
    return replace(graph, run=replace(graph.run, seed=about.seed))


def _is_of_log(saved: bytes, about: About | None) -> bool:
    """Whether the graph beside a log is the one that the log says, but for where paths begin."""
    if about is None:
        return True
    return _is_same(_section(saved, "stages"), _section(_yaml_of(about), "stages"))


def _yaml_of(about: About) -> bytes:
    return about.graph_yaml.encode("utf-8", "replace")


def _section(data: bytes, key: str) -> dict[str, Any]:
    """Return a mapping of a graph, empty where it has none."""
    try:
        plain = parse_yaml(data, GRAPH)[0].plain()
    except UserError:
        return {}
    return _mapping(plain.get(key)) if isinstance(plain, dict) else {}


def _mapping(found: Any) -> dict[str, Any]:
    return found if isinstance(found, dict) else {}


def _is_same(saved: Any, logged: Any) -> bool:
    if isinstance(saved, dict) and isinstance(logged, dict):
        return saved.keys() == logged.keys() and all(_is_same(saved[key], logged[key]) for key in saved)
    if isinstance(saved, list) and isinstance(logged, list):
        return len(saved) == len(logged) and all(map(_is_same, saved, logged))
    if isinstance(saved, str) and isinstance(logged, str):
        return saved == logged or PurePath(saved).name == PurePath(logged).name
    return bool(saved == logged)


def _printable(text: str) -> str:
    return "".join(char if char.isprintable() or char == "\n" else ascii(char)[1:-1] for char in text)
