"""Parameters of stages: class fields with a default, bounds, a type and help."""

from __future__ import annotations

import dataclasses
import math
import re
import types
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from graphnav.core.errors import DeclarationError, Hint, ParamError, did_you_mean

REQUIRED = dataclasses.MISSING
_SCALARS = (bool, int, float, str, Path)
_YES_AND_NO = {"yes": True, "on": True, "no": False, "off": False}
_TYPE_NAMES = {bool: "true or false", int: "an integer", float: "a number", str: "a string", Path: "a path"}

MIN_MAGNITUDE, MAX_MAGNITUDE = 1e-12, 1e12
"""Of every number but 0: squares and ratios of values within these limits are still finite and not 0."""


@dataclass(frozen=True)
class Param:
    """The declaration of a parameter."""

    name: str
    type: Any
    default: Any
    doc: str
    ge: float | None = None
    gt: float | None = None
    le: float | None = None
    lt: float | None = None
    renamed_from: str | None = None
    """The name in older versions: refused in graphs that users write, accepted in records."""
    changes: tuple[str, ...] = ()
    """Of a source: the outputs that it changes, if it changes no more; empty: perhaps all."""

    @property
    def required(self) -> bool:
        """Whether a graph must give the parameter."""
        return self.default is REQUIRED

    @property
    def type_text(self) -> str:
        """The type in words."""
        return type_text(self.type)

    @property
    def bounds_text(self) -> str:
        """The bounds as in ``>= 0 and < 1``, empty if there are none."""
        signs = ((">=", self.ge), (">", self.gt), ("<=", self.le), ("<", self.lt))
        return " and ".join(f"{sign} {_number(bound)}" for sign, bound in signs if bound is not None)

    def parse(self, value: Any) -> Any:
        """Return ``value`` (from YAML, a command line or Python) as the declared type.

        Raises
        ------
        ParamError
            It has another type, is not finite or is out of bounds.
        """
        parsed = _convert(self.name, self.type, value)
        for number in _numbers(parsed):
            self._check_bounds(number)
        return parsed

    @cached_property
    def parsed_default(self) -> Any:
        """The default as the declared type; raises ParamError as `parse` does."""
        return self.parse(self.default)

    def accepts(self, value: Any) -> bool:
        """Return whether `parse` reads ``value``."""
        try:
            self.parse(value)
        except ParamError:
            return False
        return True

    def _check_bounds(self, number: float) -> None:
        fits = (
            (self.ge is None or number >= self.ge)
            and (self.gt is None or number > self.gt)
            and (self.le is None or number <= self.le)
            and (self.lt is None or number < self.lt)
        )
        if not fits:
            raise ParamError(self.name, f"'{self.name}' is {_number(number)}, but must be {self.bounds_text}")


def param(
    default: Any = REQUIRED,
    *,
    doc: str,
    ge: float | None = None,
    gt: float | None = None,
    le: float | None = None,
    lt: float | None = None,
    renamed_from: str | None = None,
    changes: tuple[str, ...] = (),
) -> Any:
    """Declare a parameter of a stage.

    Parameters
    ----------
    default
        Value if a graph does not give one, checked as if it did; without a default the graph must.
    doc
        Meaning, and the effect of larger and smaller values. The unit is the suffix of the name (``_px``, ``_s``, ...);
        a float without a unit is documented as "dimensionless".
    ge, gt, le, lt
        Bounds: minimum, exclusive minimum, maximum, exclusive maximum. Apply to every number of a tuple or mapping.
    renamed_from
        Former name. A graph that uses it is refused with the new name as the suggestion; the graph of a log or a run
        folder is read as if it used the new name.
    changes
        Of a source: the outputs that it changes, if it changes no others, as the noise of a camera changes the image
        alone. In a study, variants with another value meet the same frames where nothing that drives reads these
        outputs; without ``changes`` they do not.
    """
    declared = {"doc": doc, "ge": ge, "gt": gt, "le": le, "lt": lt, "renamed_from": renamed_from, "changes": changes}
    return dataclasses.field(default=default, kw_only=True, metadata={"param": declared})


def params_of(cls: type) -> Mapping[str, Param]:
    """Return the declared parameters of a stage class, in order.

    Raises
    ------
    DeclarationError
        A field is declared without `param`, or has an unsupported type.
    """
    return _params_of(cls)


@cache
def _params_of(cls: Any) -> Mapping[str, Param]:
    hints = get_type_hints(cls)
    found = {}
    for f in dataclasses.fields(cls):
        if "param" not in f.metadata:
            raise DeclarationError(
                f"field '{f.name}' of {cls.__qualname__} is not a parameter: "
                f"write {f.name}: ... = param(..., doc=...), "
                "or assign it in reset() if it is state"
            )
        if not _is_supported(hints[f.name]):
            raise DeclarationError(
                f"parameter '{f.name}' of {cls.__qualname__} has type {hints[f.name]}: "
                "use bool, int, float, str, Path, Literal, a tuple or Mapping[str, ...] of them, or one of these | None"
            )
        found[f.name] = Param(f.name, hints[f.name], f.default, **f.metadata["param"])
    return MappingProxyType(found)


def type_text(kind: Any) -> str:
    """Return a parameter's type in words: ``"mad" or "otsu"``, ``a number``."""
    origin, args = get_origin(kind), get_args(kind)
    if origin is Literal:
        return _any_of([f'"{a}"' if isinstance(a, str) else str(a) for a in args])
    if origin is tuple:
        if args[-1] is Ellipsis:
            return f"a list, each {type_text(args[0])}"
        return "[" + ", ".join(type_text(a) for a in args) + "]"
    if origin is Mapping:
        return f"a mapping, each {type_text(args[1])}"
    if origin in (Union, types.UnionType):
        null = ["null"] if type(None) in args else []
        return _any_of([type_text(a) for a in args if a is not type(None)] + null)
    return _TYPE_NAMES.get(kind, str(kind))


def _any_of(words: list[str]) -> str:
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " or " + words[-1]


def _is_supported(kind: Any) -> bool:
    origin, args = get_origin(kind), get_args(kind)
    if origin is Literal:
        return True
    if origin is tuple:
        return all(a is Ellipsis or _is_supported(a) for a in args)
    if origin is Mapping:
        return args[0] is str and _is_supported(args[1])
    if origin in (Union, types.UnionType):
        return all(a is type(None) or _is_supported(a) for a in args)
    return kind in _SCALARS


def _convert(name: str, kind: Any, value: Any) -> Any:
    origin, args = get_origin(kind), get_args(kind)
    if origin is Literal:
        if any(value == a and type(value) is type(a) for a in args):
            return value
    elif origin in (tuple, Mapping):
        if (items := _convert_items(name, kind, value)) is not None:
            return items
    elif origin in (Union, types.UnionType):
        return _convert_union(name, kind, value)
    elif kind is float:
        if isinstance(value, int | float) and not isinstance(value, bool):
            return _as_float(name, value)
    elif kind is Path:
        if isinstance(value, str | Path) and str(value):
            return Path(value)
        if type(value) is int and value >= 0:
            return Path(str(value))  # a camera's number, or a folder named like one
    elif type(value) is kind:
        return value
    raise ParamError(name, f"'{name}' must be {type_text(kind)}, not {_shown(value)}", _hint(kind, value))


def _convert_items(name: str, kind: Any, value: Any) -> Any:
    """Return a list as a tuple or a mapping as one that is read-only, None for anything else than ``kind``."""
    args = get_args(kind)
    if get_origin(kind) is Mapping:
        if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
            try:
                return MappingProxyType({key: _convert(f"{name}.{key}", args[1], item) for key, item in value.items()})
            except ParamError as error:
                raise ParamError(name, error.what, error.hint) from error
    elif isinstance(value, list | tuple):
        each = [args[0]] * len(value) if args[-1] is Ellipsis else list(args)
        if len(each) == len(value):
            return tuple(_convert(name, k, v) for k, v in zip(each, value, strict=True))
    return None


def _as_float(name: str, value: float) -> float:
    if isinstance(value, float) and not math.isfinite(value):
        raise ParamError(name, f"'{name}' is {value}, but must be finite")
    if abs(value) > MAX_MAGNITUDE:
        raise ParamError(name, f"'{name}' is too large a number")
    if 0 < abs(value) < MIN_MAGNITUDE:
        raise ParamError(name, f"'{name}' is too near to 0", f"write 0, or a number from {MIN_MAGNITUDE:g}")
    return float(value)


def _convert_union(name: str, kind: Any, value: Any) -> Any:
    if value is None and type(None) in get_args(kind):
        return None
    if isinstance(value, str) and "://" in value and str in get_args(kind):
        return value  # Path would drop one of the slashes
    for member in get_args(kind):
        if member is type(None):
            continue
        try:
            return _convert(name, member, value)
        except ParamError:
            continue
    raise ParamError(name, f"'{name}' must be {type_text(kind)}, not {_shown(value)}", _hint(kind, value))


def _hint(kind: Any, value: Any) -> Hint:
    if not isinstance(value, str):
        return ""
    if kind is bool and value.lower() in _YES_AND_NO:
        return f"write {'true' if _YES_AND_NO[value.lower()] else 'false'}"
    members = get_args(kind) if get_origin(kind) in (Union, types.UnionType) else (kind,)
    choices = [a for m in members if get_origin(m) is Literal for a in get_args(m) if isinstance(a, str)]
    if not choices and float in members and re.fullmatch(r"[-+.0-9eE]+", value):
        return "remove the quotes"
    return did_you_mean(value, choices)


def _numbers(value: Any) -> Iterator[float]:
    """Yield the numbers of a parsed value, those in tuples and mappings too."""
    if isinstance(value, tuple | Mapping):
        for item in value.values() if isinstance(value, Mapping) else value:
            yield from _numbers(item)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield value


def _number(number: float) -> str:
    return str(number) if isinstance(number, int) else f"{number:.12g}"


def _shown(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f"the string '{value}'" if len(value) <= 60 else f"a string of {len(value)} characters"
    if isinstance(value, Mapping):
        return "a mapping"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    return str(value)
