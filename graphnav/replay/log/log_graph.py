"""Load the graph and seed that produced a log."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePath
from typing import Any

from graphnav import About, Graph, Place, Recording, Status, UserError, shown_path
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override, Target, graph_of, load_graph
from graphnav.core.messages import Changed
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import complete_channels
from graphnav.core.spec import RecordOption, option_in, parse_yaml, read_bytes
from graphnav.replay.log.changes import StageChange, read_changes

_SEED = Target("run", key="seed")


@dataclass(frozen=True)
class LogGraph:
    """The graph to replay, and the description in the log, None without one."""

    graph: Graph
    about: About | None
    complete: frozenset[str]
    """The channels of which the log keeps every message, by its ``record`` option."""
    is_live: bool
    """Whether it is the log of a live run."""
    wires: Mapping[str, Mapping[str, str]]
    """The channels read by each stage's inputs in that run, by stage and port."""
    recorded: Graph | None = None
    """The graph of the run itself, where its sources make again what the log leaves out."""
    changes: tuple[StageChange, ...] = ()
    """The stages that were rebuilt while the run went on, in the order of their times."""


def graph_to_replay(
    recording: Recording,
    catalog: Catalog,
    *,
    graph: str | Path | None = None,
    overrides: Sequence[Override] = (),
    plugins: Sequence[Path] = (),
) -> LogGraph:
    """Return the graph of a log with overrides, or the one that ``graph`` names, with the seed of the log.

    The graph of a run folder is loaded from its ``graph.yaml``, with the plugins in the folder; other logs never load
    plugins. ``plugins`` are already in the catalog, and replace plugins of the same file name.

    Raises
    ------
    UserError
        The log does not hold its graph, or the graph has errors.
    """
    about = recording.about
    names = {path.name for path in plugins}
    if graph is not None:
        found = load_graph(graph, catalog, overrides)
    else:
        found = _own_graph(recording, about, catalog, overrides, names)
    recorded = None
    if _option(about) == "replayable" and not is_live(about):
        recorded = _own_graph(recording, about, catalog, (), names)
    found = _with_seed(found, about, overrides)
    if graph is not None and recording.count(Changed.CHANNEL):
        what = (
            f"{shown_path(recording.path)} tells of changes of stages while it ran: they are not repeated with --graph"
        )
        return _log_graph(replace(found, notices=(*found.notices, what)), about, recorded)
    changes, notices = read_changes(recording, found, catalog)
    written = {channel.ref: channel for change in changes for channel in change.node.outputs.values()}
    found = replace(found, channels=written | dict(found.channels), notices=(*found.notices, *notices))
    return replace(_log_graph(found, about, recorded), changes=changes)


def _own_graph(
    recording: Recording, about: About | None, catalog: Catalog, overrides: Sequence[Override], given: Collection[str]
) -> Graph:
    """Return the graph of a run folder, else the graph in the log; ``given``: names of loaded plugins."""
    saved, notice = recording.path.parent / RunFolder.GRAPH, ""
    if recording.path.name == RunFolder.LOG and saved.is_file():
        data = read_bytes(saved, Place(shown_path(saved)))
        differing = _differing_section(data, about)
        if not differing:
            return graph_of(data, saved, catalog, overrides, shown_path(saved), given, is_record=True)
        notice = f"{shown_path(saved)} is not the graph of the log: '{differing}' differs; that of the log is stepped"
    source = shown_path(recording.path)
    if about is None:
        what = f"{source} does not hold the graph that produced it: no readable '{About.CHANNEL}'"
        raise UserError.of(what, "name the graph with --graph FILE")
    source = f"{source} ({About.CHANNEL})"
    data = _yaml_of(about)
    plain = parse_yaml(data, source)[0].plain()
    words = plain if isinstance(plain, dict) else {}
    if "extends" in words:
        what = "the graph of this log extends another graph, but recorded graphs are complete"
        raise UserError.of(what, "name the graph with --graph FILE", Place(source))
    listed = words.get("plugins")
    named = [PurePath(str(item)).name for item in listed] if isinstance(listed, list) else []
    absent = [name for name in named if name not in given]
    if absent:
        what = f"the graph of this log needs the plugin '{absent[0]}'"
        raise UserError.of(what, "name the file with --plugin FILE", Place(source))
    found = graph_of(data, recording.path, catalog, overrides, source, named, is_record=True)
    return replace(found, notices=(notice, *found.notices)) if notice else found


def _log_graph(graph: Graph, about: About | None, recorded: Graph | None) -> LogGraph:
    by_wall_clock = is_live(about)
    complete = complete_channels(recorded or graph, _option(about), is_live=by_wall_clock)
    if about is None:
        return LogGraph(graph, about, complete, by_wall_clock, wires={})
    stages = _section(_yaml_of(about), "stages").items()
    wires = {name: _mapping(stage.get("in")) for name, stage in stages if isinstance(stage, dict)}
    return LogGraph(graph, about, complete, by_wall_clock, wires, recorded)


def is_live(about: About | None) -> bool:
    """Whether it is the log of a live run."""
    return about is not None and Status.CHANNEL in about.channels


def _option(about: About | None) -> RecordOption:
    """Return what the log keeps; one of lockstep that does not say, before version 0.8, keeps everything."""
    given = None if about is None else option_in(_section(_yaml_of(about), "run").get("record"))
    return given or ("small" if is_live(about) else "all")


def _with_seed(graph: Graph, about: About | None, overrides: Sequence[Override]) -> Graph:
    """Return a graph with the seed of the log, unless an override gives another one."""
    is_given = any(override.target == _SEED for override in overrides)
    if about is None or is_given:
        return graph
    return replace(graph, run=replace(graph.run, seed=about.seed))


_UNLIKE = "plugins", "deploy"
"""Keys of a graph that are not written alike into the log."""


def _differing_section(saved: bytes, about: About | None) -> str:
    """Return the first key of the graph beside a log that is not as in the log, empty if everything is the same.

    Paths are absolute in one, and plugins are copies in the other; those of ``--plugin`` are not in the log, nor are
    the processes of the stages.
    """
    if about is None:
        return ""
    ours, logged = _plain(saved), _plain(_yaml_of(about))
    if not _plugin_names(logged) <= _plugin_names(ours):
        return "plugins"
    keys = dict.fromkeys((*logged, *ours))
    return next((k for k in keys if k not in _UNLIKE and not _is_same(ours.get(k), logged.get(k))), "")


def _plugin_names(graph: Mapping[str, Any]) -> set[str]:
    listed = graph.get("plugins")
    return {PurePath(str(item)).name for item in listed} if isinstance(listed, list) else set()


def _yaml_of(about: About) -> bytes:
    return about.graph_yaml.encode("utf-8", "replace")


def _section(data: bytes, key: str) -> dict[str, Any]:
    """Return a section of a graph, empty if it is missing."""
    return _mapping(_plain(data).get(key))


def _plain(data: bytes) -> dict[str, Any]:
    """Return a graph as plain data, empty if it is not YAML."""
    try:
        return _mapping(parse_yaml(data, RunFolder.GRAPH)[0].plain())
    except UserError:
        return {}


def _mapping(found: Any) -> dict[str, Any]:
    return found if isinstance(found, dict) else {}


def _is_same(saved: Any, logged: Any) -> bool:
    if isinstance(saved, dict) and isinstance(logged, dict):
        return saved.keys() == logged.keys() and all(_is_same(saved[key], logged[key]) for key in saved)
    if isinstance(saved, list) and isinstance(logged, list):
        return len(saved) == len(logged) and all(map(_is_same, saved, logged))
    if isinstance(saved, str) and isinstance(logged, str) and PurePath(saved).is_absolute():
        return saved == logged or _is_below(PurePath(os.path.normpath(saved)), PurePath(os.path.normpath(logged)))
    return bool(saved == logged)


def _is_below(path: PurePath, written: PurePath) -> bool:
    """Return whether an absolute path ends as a graph writes it from some folder: ``../maps/room.yaml``."""
    parts = [part for part in written.parts if part != ".." and not part.startswith("~")]
    return not written.is_absolute() and path.parts[-len(parts) :] == tuple(parts)
