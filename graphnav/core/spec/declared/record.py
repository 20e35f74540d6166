"""A mapping of a file, declared by a class whose fields are the mapping's keys."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any, ClassVar, Generic, TypeVar, dataclass_transform, get_type_hints

from graphnav.core.errors import DeclarationError, Place
from graphnav.core.stage.param import REQUIRED, Param

Number = TypeVar("Number", int, float)
Path = tuple[str, ...]
"""The keys and the positions in lists that lead from the root of a file to a value."""


@dataclass(frozen=True)
class Range(Generic[Number]):
    """A number that a file gives as such, or as ``[low, high]``, to be drawn from the seed of a run."""

    low: Number
    high: Number
    path: Path = ()


@dataclass(frozen=True)
class Written:
    """Where the parts of a record are in its file."""

    places: Mapping[Path, Place] = dataclasses.field(default_factory=dict)
    """Of values."""
    key_places: Mapping[Path, Place] = dataclasses.field(default_factory=dict)
    path: Path = ()

    def has(self, *parts: str) -> bool:
        """Whether the file says anything there, right or wrong."""
        return (*self.path, *parts) in self.places


@dataclass_transform(kw_only_default=True, frozen_default=True)
@dataclass(frozen=True, kw_only=True)
class Record:
    """A declared mapping; subclasses declare their fields by `key`.

    Types of fields: ``bool``, ``int``, ``float``, ``str``, ``Path``, a ``Literal``; a ``Range[float]`` or
    ``Range[int]``; another record; ``tuple[T, ...]``, a list; a ``NamedTuple``, a list with a meaning for each
    position; ``Mapping[str, T]``, names that are free; ``Value``, anything; and unions of those that differ in kind
    (mapping, list, scalar, null).
    """

    noun: ClassVar[str] = "this mapping"
    """Noun for one such mapping in error messages: "a wall"."""
    named: ClassVar[str] = ""
    """Where names are free, what messages call the one of a name: "stage '{}'". Nothing under a name is a mapping."""
    short: ClassVar[str] = ""
    """The key that is proposed where a string stands in place of one that has a name."""
    one_of: ClassVar[tuple[str, ...]] = ()
    """Keys of which exactly one is given."""
    renamed: ClassVar[Mapping[str, str]] = MappingProxyType({})
    """Names that keys had, and those that they have."""
    conditions: ClassVar[Mapping[str, Any]] = MappingProxyType({})
    """Keywords of a JSON Schema for keys that depend on each other; what reads it checks the same."""
    example: ClassVar[str] = ""
    """YAML of one of it, for the reference page."""

    written: Written = dataclasses.field(default_factory=Written, repr=False, compare=False)

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Make the annotated fields of ``cls`` keyword arguments of its constructor."""
        super().__init_subclass__(**kwargs)
        dataclass(frozen=True, kw_only=True)(cls)

    def place(self, *parts: str) -> Place | None:
        """Return the place of a part of it in the file: that of what it is in, if it is not given."""
        path = (*self.written.path, *parts)
        found = (self.written.places.get(path[:length]) for length in range(len(path), -1, -1))
        return next((place for place in found if place), None)

    def key_place(self, *parts: str) -> Place | None:
        """Return the place of the key of a part of it."""
        return self.written.key_places.get((*self.written.path, *parts))


@dataclass(frozen=True)
class Names:
    """Legal names in a mapping with free names."""

    pattern: str
    """A regular expression."""
    what: str = ""
    """Noun in messages for what another one cannot be: "a stage's name"; empty where only a JSON Schema refuses it."""
    hint: str = ""


@dataclass(frozen=True)
class Key:
    """A declared key."""

    name: str
    type: Any
    default: Any
    doc: str
    bounds: Mapping[str, float | None]
    min_items: int = 0
    hint: str = ""
    field: str = ""
    """The field of the record."""
    missing: str = ""
    pattern: str = ""
    not_empty: bool = False
    names: Names | None = None

    @property
    def required(self) -> bool:
        """Whether a file has to give it."""
        return self.default is REQUIRED

    @property
    def plain_default(self) -> Any:
        """The default as YAML holds it, None where there is nothing to tell."""
        if isinstance(self.default, Range):
            return self.default.low
        return None if self.required or self.default == () else self.default

    def as_param(self, kind: Any, name: str) -> Param:
        """Return what reads one scalar of it; messages call it ``name``."""
        ge, gt, le, lt = (self.bounds.get(key) for key in ("ge", "gt", "le", "lt"))
        return Param(name, kind, self.default, self.doc, ge=ge, gt=gt, le=le, lt=lt)


def key(
    default: Any = REQUIRED,
    *,
    doc: str,
    ge: float | None = None,
    gt: float | None = None,
    le: float | None = None,
    lt: float | None = None,
    min_items: int = 0,
    hint: str = "",
    name: str = "",
    missing: str = "",
    pattern: str = "",
    not_empty: bool = False,
    names: Names | None = None,
) -> Any:
    """Declare a key of a `Record`.

    Parameters
    ----------
    default
        Its value where a file does not give it; without one it is required.
    doc
        What it means. The unit is in the name (``_m``, ``_deg``, …).
    ge, gt, le, lt
        Bounds of every number in it: at least, above, at most, below.
    min_items
        The shortest list or mapping.
    hint
        What errors propose: "write ...".
    name
        The key, where Python has no such name for a field.
    missing
        Said in messages of the mapping if a required key is not given: "does not say what it uses".
    pattern
        A regular expression of its strings, for a JSON Schema alone: what uses them tells more precisely what is wrong.
    not_empty
        Whether its strings must have characters.
    names
        Legal names, where they are free.
    """
    bounds = {"ge": ge, "gt": gt, "le": le, "lt": lt}
    metadata = {"doc": doc, "bounds": bounds, "min_items": min_items, "hint": hint, "name": name, "missing": missing}
    metadata |= {"pattern": pattern, "not_empty": not_empty, "names": names}
    return dataclasses.field(default=default, kw_only=True, metadata=metadata)


def keys_of(cls: type) -> Mapping[str, Key]:
    """Return the declared keys of a record, in order.

    Raises
    ------
    DeclarationError
        A field is not declared by `key`.
    """
    return _keys_of(cls)


@cache
def _keys_of(cls: Any) -> Mapping[str, Key]:
    hints = get_type_hints(cls)
    found = {}
    for field in dataclasses.fields(cls):
        if field.name == "written":
            continue
        if "doc" not in field.metadata:
            what = f"field '{field.name}' of {cls.__qualname__} is not a key: write {field.name}: ... = key(doc=...)"
            raise DeclarationError(what)
        name = field.metadata["name"] or field.name
        declared = {word: value for word, value in field.metadata.items() if word != "name"}
        found[name] = Key(name, hints[field.name], field.default, field=field.name, **declared)
    return MappingProxyType(found)
