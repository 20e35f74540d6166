"""Where `Path` parameters point to."""

from __future__ import annotations

import os
import re
import types
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Union, get_args, get_origin

from graphnav.core.graph.find import shipped_folder

_URL = re.compile(r"[a-z][a-z0-9+.-]*:/")
_GLOB = re.compile(r"[*?\[]")


@cache
def has_path(kind: Any) -> bool:
    """Return whether values of a parameter's type may be paths."""
    return kind is Path or any(has_path(member) for member in get_args(kind))


@dataclass(frozen=True)
class Resolved:
    """A path parameter, for the stage and for graphs that are written again."""

    value: Any
    anywhere: Any


def resolve_paths(kind: Any, value: Any, base: Path) -> Resolved:
    """Return the paths in a parsed value, resolved against ``base``, then the data that ships.

    What is found is absolute. What is not is meant relative to ``base``, for the stage to complain. Patterns
    (``*.jpg``) are resolved like the files that they match. URLs and device numbers, which name no file, stay.
    """
    if isinstance(value, tuple):
        each = [resolve_paths(member, item, base) for member, item in _members(kind, value)]
        return Resolved(tuple(r.value for r in each), tuple(r.anywhere for r in each))
    if isinstance(value, Path):
        return _resolve(value, base)
    return Resolved(value, value)


def _members(kind: Any, value: tuple[Any, ...]) -> list[tuple[Any, Any]]:
    if get_origin(kind) in (Union, types.UnionType):
        kind = next((k for k in get_args(kind) if get_origin(k) is tuple), tuple[Any, ...])
    kinds = get_args(kind)
    if kinds and kinds[-1] is Ellipsis:
        kinds = (kinds[0],) * len(value)
    return list(zip(kinds, value, strict=True))


def _resolve(path: Path, base: Path) -> Resolved:
    if _URL.match(str(path)):
        return Resolved(path, path)
    beside = (base / os.path.expanduser(path)).absolute()  # an unknown ~user stays as it is
    if _is_there(beside):
        return Resolved(beside, beside)
    shipped = shipped_folder() / path
    if not path.is_absolute() and _is_there(shipped):
        return Resolved(shipped.absolute(), path)
    if str(path).isdecimal():
        return Resolved(path, path)
    return Resolved(beside, beside)


def beside(value: Any, folder: Path) -> Any:
    """Return plain data with every string absolute that names something in ``folder``; else as it is."""
    if isinstance(value, list):
        return [beside(item, folder) for item in value]
    return str(folder / value) if isinstance(value, str) and _is_in(folder, value) else value


def _is_in(folder: Path, path: str) -> bool:
    """Return whether there is such a file, or one that a pattern (``*.jpg``) matches."""
    try:
        return (folder / path).exists() or any(folder.glob(path))
    except (OSError, ValueError, NotImplementedError):  # too long, with a null character, or absolute
        return False


def _is_there(path: Path) -> bool:
    try:
        if path.exists():
            return True
        pattern = path.relative_to(path.anchor)
        return bool(_GLOB.search(str(path))) and any(Path(path.anchor).glob(str(pattern)))
    except (OSError, ValueError):  # a name too long, or with a null character
        return False
