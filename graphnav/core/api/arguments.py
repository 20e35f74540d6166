"""Check arguments of the Python interface by their declarations: errors name argument, value and what to write."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np

from graphnav.core.api.parameters import Shared
from graphnav.core.errors import Place, UserError
from graphnav.core.graph import Override, Target
from graphnav.core.parameters import Integer, Parameter

T = TypeVar("T")

PathLike = str | os.PathLike[str]

_MAX_DEPTH = 20
"""Lists within lists."""
_MAX_SHOWN = 60
_MAX_S = 1e12


def path_of(value: object, parameter: Parameter, index: str = "") -> Path:
    """Return a path; ``index`` of its place in a list: ``[0]``.

    Raises
    ------
    UserError
        It is not a string or a path, or empty.
    """
    if not isinstance(value, str | os.PathLike) or not (text := os.fspath(value)) or not isinstance(text, str):
        name = f"{parameter.name}{index}"
        raise wrong_type(name, value, "a path", f"write {name}={parameter.example}")
    return Path(text)


def paths_of(values: object, parameter: Parameter) -> tuple[Path, ...]:
    """Return several paths.

    Raises
    ------
    UserError
        It is not a list of strings or paths.
    """
    return tuple(path_of(value, parameter, f"[{number}]") for number, value in enumerate(_listed(values, parameter)))


def texts_of(values: object, parameter: Parameter) -> tuple[str, ...]:
    """Return several strings.

    Raises
    ------
    UserError
        It is not a list of strings.
    """
    found = tuple(_listed(values, parameter))
    for number, value in enumerate(found):
        if not isinstance(value, str):
            hint = f"write {parameter.name}=[{parameter.example}]"
            raise wrong_type(f"{parameter.name}[{number}]", value, "a string", hint)
    return tuple(map(str, found))


def check_text(value: object, parameter: Parameter, wanted: str = "a string or None") -> None:
    """Raise UserError for a value that is neither a string nor None."""
    if value is not None and not isinstance(value, str):
        raise wrong_type(parameter.name, value, wanted, parameter.hint)


def check_number(value: object, parameter: Parameter) -> None:
    """Raise UserError for a value that is neither a number nor None."""
    if value is not None and (isinstance(value, bool) or not isinstance(plain(value, parameter.name), int | float)):
        raise wrong_type(parameter.name, value, "a number or None", parameter.hint)


def check_integer(value: object, parameter: Parameter, index: str = "") -> None:
    """Raise UserError for a value that is not an integer within the parameter's bounds; ``index`` as in `path_of`."""
    bounds = parameter.type
    assert isinstance(bounds, Integer)
    if isinstance(value, bool) or not isinstance(value, int) or not bounds.minimum <= value <= bounds.maximum:
        name = f"{parameter.name}{index}"
        is_large = isinstance(value, int) and value > bounds.maximum
        wanted = f"at most {bounds.maximum}" if is_large else f"an integer of at least {bounds.minimum}"
        raise wrong_type(name, value, wanted, f"write {name}={parameter.example}")


def check_choice(value: object, parameter: Parameter) -> None:
    """Raise UserError for a value that the parameter does not offer."""
    choices = parameter.choices or ()
    if value not in choices:
        *others, last = (f'"{choice}"' for choice in choices)
        raise wrong_type(parameter.name, value, f"{', '.join(others)} or {last}", parameter.hint)


def overrides_of(values: object) -> tuple[Override, ...]:
    """Return the overrides of a mapping of targets to values.

    Raises
    ------
    UserError
        It is not a mapping, a key is not a target, or a graph cannot hold a value.
    """
    if values is None:
        return ()
    if not isinstance(values, Mapping):
        raise wrong_type("set", values, "a mapping", Shared.SET.hint)
    found = []
    for target, value in values.items():
        if not isinstance(target, str) or not target or "=" in target:
            raise UserError.of(f"set: {target!r} is not a stage, a parameter or a wire", Shared.SET.hint)
        place = Place(f"set[{target!r}]")
        found.append(Override(Target.parse(target, place), yaml_value(value, place.file), place))
    return tuple(found)


def yaml_value(value: object, name: str) -> object:
    """Return a value as plain YAML data: without numpy's types, paths as strings.

    Raises
    ------
    UserError
        A graph cannot contain it.
    """
    value = plain(value, name)
    if isinstance(value, list):
        return [yaml_value(item, name) for item in value]
    return str(value) if isinstance(value, Path) else value


def plain(value: object, name: str, depth: int = 0) -> object:
    """Return a value without numpy types; ``depth``: of the lists that contain it.

    Raises
    ------
    UserError
        A graph cannot contain it.
    """
    if depth > _MAX_DEPTH:
        what = f"{name} has lists in more than {_MAX_DEPTH} others, or one that contains itself"
        raise UserError.of(what, "write a list of values")
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain(item, name, depth + 1) for item in value]
    if value is None or isinstance(value, bool | int | float | str | Path):
        return value
    raise wrong_type(name, value, "a string, number, bool, None, path or a list of these", "write its name or value")


def seconds_of(value: object, name: str) -> int | None:
    """Return a time in microseconds, None for None.

    Raises
    ------
    UserError
        It is not a finite number.
    """
    if value is None:
        return None
    value = plain(value, name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise wrong_type(name, value, "a number of seconds", f"write {name}=1.5")
    if not math.isfinite(value) or abs(value) > _MAX_S:
        raise UserError.of(f"{name} is {value:g}, but must be a number of seconds", f"write {name}=1.5")
    return round(value * 1e6)


def wrong_type(name: str, value: object, wanted: str, hint: str) -> UserError:
    """Return the error for an argument of a wrong type."""
    said = "None" if value is None else f"{_shown(value)} ({type(value).__name__})"
    return UserError.of(f"{name} must be {wanted}, not {said}", hint)


def _listed(values: object, parameter: Parameter) -> Iterable[object]:
    if isinstance(values, str | os.PathLike | Mapping) or not isinstance(values, Iterable):
        raise wrong_type(parameter.name, values, "a list", f"write {parameter.name}=[{parameter.example}]")
    return values


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= _MAX_SHOWN and text.isprintable() else "a value"
