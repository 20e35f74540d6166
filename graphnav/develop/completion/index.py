"""The names of all installed stages, graphs, studies, maps, channels and types, as plain data that is cached."""

from __future__ import annotations

import importlib.util
import json
import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args, get_origin

from graphnav import GraphnavError
from graphnav.core.machine import read_json, user_folder, write_atomically

if TYPE_CHECKING:
    from graphnav.core.catalog import Catalog

_OWN = ("graphnav", "graphnav_graphs", "graphnav_lcm")
_GROUP = "graphnav"


@dataclass(frozen=True)
class Index:
    """All names that can be completed without knowing the working folder."""

    families: list[str] = field(default_factory=list)
    params: dict[str, dict[str, list[str]]] = field(default_factory=dict)
    """By stage (``plane.ica``) and parameter: the values, where they can be listed."""
    ports: dict[str, list[str]] = field(default_factory=dict)
    """Inputs by stage."""
    filters: list[str] = field(default_factory=list)
    """Stages that need a message such as they write, and so cannot take the place of what makes it."""
    run_options: dict[str, list[str]] = field(default_factory=dict)
    graphs: dict[str, dict[str, str]] = field(default_factory=dict)
    """Graphs that ship: the stage class of each stage."""
    studies: dict[str, list[str]] = field(default_factory=dict)
    """Studies that ship, with their graphs."""
    files: list[str] = field(default_factory=list)
    """Maps and planar models that ship, as graphs name them."""
    channels: list[str] = field(default_factory=list)
    """Channels of the graphs that ship."""
    types: list[str] = field(default_factory=list)


def build_index() -> Index:
    """Return the index; it imports every plugin, which takes about a second. Unusable ones are left out."""
    from graphnav.core.catalog import Catalog
    from graphnav.core.graph import shipped_folder
    from graphnav.core.spec import RunKeys, keys_of

    catalog = Catalog()
    index = Index(families=list(catalog.families()))
    folder = shipped_folder()
    paths = (path for name in ("maps", "models") for path in sorted(folder.glob(f"{name}/*.*")))
    index.files.extend(path.relative_to(folder).as_posix() for path in paths)
    index.run_options.update({name: _values(key.type, []) for name, key in keys_of(RunKeys).items()})
    for family in index.families:
        with suppress(GraphnavError):
            _add_stages(index, catalog, family)
    _add_graphs(index, catalog)
    _add_types(index)
    return index


def _add_stages(index: Index, catalog: Catalog, family: str) -> None:
    from graphnav.core.stage import params_of, ports_of

    for name in catalog.names(family):
        cls = catalog.stage(f"{family}.{name}")
        values = {param.name: _values(param.type, _files_for(param.name, index)) for param in params_of(cls).values()}
        index.params[f"{family}.{name}"] = values
        ports = ports_of(cls)
        index.ports[f"{family}.{name}"] = [port.name for port in ports.inputs]
        made = {port.message for port in ports.outputs}
        if any(port.message in made and not (port.latest or port.since) for port in ports.inputs):
            index.filters.append(f"{family}.{name}")


def _add_graphs(index: Index, catalog: Catalog) -> None:
    from graphnav.core.graph import load_graph, shipped_folder, shipped_graphs
    from graphnav.core.spec import parse_yaml

    channels: dict[str, None] = {}
    for name, path in shipped_graphs().items():
        with suppress(GraphnavError):
            graph = load_graph(path, catalog)
            index.graphs[name] = {node.name: node.use for node in graph.nodes}
            channels |= {channel.name: None for channel in graph.channels.values()}
    index.channels.extend(sorted(channels))
    for path in sorted((shipped_folder() / "studies").glob("*.yaml")):
        with suppress(GraphnavError):
            words = parse_yaml(path.read_bytes(), path.name)[0].plain()
            index.studies[path.stem] = [str(name) for name in words.get("graphs", [words.get("graph", "")])]


def _add_types(index: Index) -> None:
    """Add the messages of all plugins, and the LCM types."""
    from graphnav.core.codec import SHIPPED, lcm_name, message_classes

    messages = list(message_classes())
    names = {message.__name__ for message in messages}
    names |= {lcm_name(found) for found in (*SHIPPED, *(message.lcm_class for message in messages))}
    index.types.extend(sorted(names))


def _files_for(param: str, index: Index) -> list[str]:
    """Return the files that ship for a parameter: ``maps/`` for ``map``, all where no folder has its name."""
    return [file for file in index.files if file.startswith(f"{param}s/")] or index.files


def _values(kind: Any, files: list[str]) -> list[str]:
    """Return the values of a type where they can be listed."""
    if get_origin(kind) is Literal:
        return [str(value) for value in get_args(kind)]
    if kind is bool:
        return ["true", "false"]
    if kind is Path:
        return files
    return [value for part in get_args(kind) for value in _values(part, files)]


def installed_index() -> Index:
    """Return the index from the cache, else build it and write the cache; a folder without rights costs only time."""
    file = cache_file()
    stamp = _stamp()
    if file is None:
        return build_index()
    with suppress(OSError, ValueError, KeyError, TypeError):
        kept = read_json(file)
        if kept["stamp"] == stamp:
            return Index(**kept["index"])
    index = build_index()
    with suppress(OSError, GraphnavError):
        file.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(file, json.dumps({"stamp": stamp, "index": asdict(index)}))
    return index


def cache_file() -> Path | None:
    """Return where the index is kept: in the user's cache folder; None without a home folder."""
    folder = user_folder("XDG_CACHE_HOME")
    return None if folder is None else folder / "completion.json"


def _stamp() -> str:
    """Return a string that changes with every package of stages and every file of it."""
    parts = []
    for package in sorted({*_OWN, *(point.value.partition(":")[0] for point in entry_points(group=_GROUP))}):
        files = [stat for folder in _folders(package) for stat in _stats(folder)]
        parts.append(f"{package} {len(files)} {max(files, default=0)}")
    return "\n".join(parts)


def _folders(package: str) -> list[str]:
    try:
        spec = importlib.util.find_spec(package)
    except (ImportError, ValueError):
        return []
    return list(spec.submodule_search_locations or []) if spec else []


def _stats(folder: str) -> Iterator[int]:
    """Yield when each file was changed, in nanoseconds."""
    for name, folders, files in os.walk(folder):
        folders[:] = [inner for inner in folders if inner != "__pycache__"]
        for file in files:
            with suppress(OSError):
                yield Path(name, file).stat().st_mtime_ns
