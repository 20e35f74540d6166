"""Keep the index between two TABs, for as long as no package that it was made from has changed."""

from __future__ import annotations

import importlib.util
import json
import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict
from importlib.metadata import entry_points
from pathlib import Path

from graphnav.core.machine import read_json, user_folder
from graphnav.develop.completion.index import Index, build_index

_OWN = ("graphnav", "graphnav_graphs", "graphnav_lcm")
_GROUP = "graphnav"


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
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        pending = file.with_suffix(f".{os.getpid()}")
        pending.write_text(json.dumps({"stamp": stamp, "index": asdict(index)}), encoding="utf-8")
        pending.replace(file)
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
