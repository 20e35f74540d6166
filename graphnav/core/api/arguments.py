"""Check arguments of the Python interface by their declarations: errors name argument, value and what to write."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from graphnav.core.errors import Place, UserError
from graphnav.core.graph import Override, Target
from graphnav.core.parameters import Integer, Parameter

PathLike = str | os.PathLike[str]

_MAX_DEPTH = 20
"""Lists within lists."""
_MAX_SHOWN = 60
_MAX_S = 1e12


@dataclass(frozen=True, eq=False)
class Argument:
    """An argument of a Python function, with the declaration of its parameter.

    ``place``: where in what was given it is, as Python writes it: ``[0]``.
    """

    value: object
    parameter: Parameter
    place: str = ""

    @property
    def name(self) -> str:
        """The name in errors."""
        return f"{self.parameter.name}{self.place}"

    def error(self, wanted: str, hint: str = "") -> UserError:
        """Return the error for a wrong type; ``hint``: by default that of the parameter."""
        return wrong_type(self.name, self.value, wanted, hint or self.parameter.hint)

    def path(self) -> Path:
        """Return a path.

        Raises
        ------
        UserError
            It is not a string or a path, or empty.
        """
        value = self.value
        if not isinstance(value, str | os.PathLike) or not (text := os.fspath(value)) or not isinstance(text, str):
            raise self.error("a path", self._hint)
        return Path(text)

    def paths(self) -> tuple[Path, ...]:
        """Return several paths.

        Raises
        ------
        UserError
            It is not a list of strings or paths.
        """
        return tuple(one.path() for one in self._each())

    def texts(self) -> tuple[str, ...]:
        """Return several strings.

        Raises
        ------
        UserError
            It is not a list of strings.
        """
        found = self._each()
        for one in found:
            if not isinstance(one.value, str):
                raise one.error("a string", self._hint_of_list)
        return tuple(str(one.value) for one in found)

    def overrides(self) -> tuple[Override, ...]:
        """Return the overrides of a mapping of targets to values.

        Raises
        ------
        UserError
            It is not a mapping, a key is not a target, or a graph cannot hold a value.
        """
        if self.value is None:
            return ()
        if not isinstance(self.value, Mapping):
            raise self.error("a mapping")
        found = []
        for target, value in self.value.items():
            if not isinstance(target, str) or not target or "=" in target:
                what = f"{self.name}: {target!r} is not a stage, a parameter or a wire"
                raise UserError.of(what, self.parameter.hint)
            one = Argument(value, self.parameter, f"[{target!r}]")
            place = Place(one.name)
            found.append(Override(Target.parse(target, place), one.yaml(), place))
        return tuple(found)

    def yaml(self) -> object:
        """Return plain YAML data: without numpy's types, paths as strings.

        Raises
        ------
        UserError
            A graph cannot contain it.
        """
        return _paths_as_text(plain(self.value, self.name))

    def check_text(self, wanted: str = "a string or None") -> None:
        """Raise UserError if it is neither a string nor None."""
        if self.value is not None and not isinstance(self.value, str):
            raise self.error(wanted)

    def check_number(self) -> None:
        """Raise UserError if it is neither a number nor None."""
        value = self.value
        if value is not None and (isinstance(value, bool) or not isinstance(plain(value, self.name), int | float)):
            raise self.error("a number or None")

    def check_integer(self) -> None:
        """Raise UserError if it is not an integer within the parameter's bounds."""
        bounds, value = self.parameter.type, self.value
        assert isinstance(bounds, Integer)
        if isinstance(value, bool) or not isinstance(value, int) or not bounds.minimum <= value <= bounds.maximum:
            is_large = isinstance(value, int) and value > bounds.maximum
            wanted = f"at most {bounds.maximum}" if is_large else f"an integer of at least {bounds.minimum}"
            raise self.error(wanted, self._hint)

    def check_choice(self) -> None:
        """Raise UserError if the parameter does not offer it."""
        choices = self.parameter.choices or ()
        if self.value not in choices:
            *others, last = (f'"{choice}"' for choice in choices)
            raise self.error(f"{', '.join(others)} or {last}")

    def _each(self) -> list[Argument]:
        values = self.value
        if isinstance(values, str | os.PathLike | Mapping) or not isinstance(values, Iterable):
            raise self.error("a list", self._hint_of_list)
        return [Argument(value, self.parameter, f"[{number}]") for number, value in enumerate(values)]

    @property
    def _hint(self) -> str:
        return f"write {self.name}={self.parameter.example}"

    @property
    def _hint_of_list(self) -> str:
        return f"write {self.parameter.name}=[{self.parameter.example}]"


def plain(value: object, name: str, depth: int = 0) -> object:
    """Return a value without numpy types; ``depth``: of the lists and mappings that contain it.

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
    if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
        return {key: plain(item, name, depth + 1) for key, item in value.items()}
    if value is None or isinstance(value, bool | int | float | str | Path):
        return value
    wanted = "a string, number, bool, None, path, or a list or mapping of these"
    raise wrong_type(name, value, wanted, "write its name or value")


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


def _paths_as_text(value: object) -> object:
    """Return plain data with strings in place of paths."""
    if isinstance(value, list):
        return [_paths_as_text(item) for item in value]
    if isinstance(value, dict):
        return {key: _paths_as_text(item) for key, item in value.items()}
    return str(value) if isinstance(value, Path) else value


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= _MAX_SHOWN and text.isprintable() else "a value"
