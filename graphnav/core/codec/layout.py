"""Read the layout of an lcm-gen class by reflection."""

from __future__ import annotations

import functools
import sys
from typing import Any, NamedTuple

Dim = int | str
"""The size of an array's axis: a number, or the name of the field that holds it."""


class Field(NamedTuple):
    """A field of an LCM type; ``dims`` is empty for a scalar, ``struct`` is None for a primitive."""

    name: str
    primitive: str
    dims: tuple[Dim, ...]
    struct: type | None


PRIMITIVES = {
    "int8_t": "b",
    "int16_t": "h",
    "int32_t": "i",
    "int64_t": "q",
    "byte": "B",
    "float": "f",
    "double": "d",
    "boolean": "?",
    "string": "",
}
"""The `struct` codes of LCM's primitives; a string has a length of its own."""


_prefixes: set[str] = set()
"""Package prefixes given to lcm-gen (``--package-prefix``), with the dot."""


def hide_prefix(prefix: str) -> None:
    """Strip the Python package ``prefix``, which LCM does not know, from the names of types."""
    _prefixes.add(prefix)


def lcm_name(lcm_class: type) -> str:
    """Return the LCM name of the type: ``graphnav_lcm.flow_t``."""
    name = ".".join([*lcm_class.__module__.split(".")[:-1], lcm_class.__name__])
    return next((name.removeprefix(prefix) for prefix in _prefixes if name.startswith(prefix)), name)


def fingerprint(lcm_class: Any) -> bytes:
    """Return the 8 bytes that every message of the type begins with."""
    packed: bytes = lcm_class._get_packed_fingerprint()  # noqa: SLF001, lcm-gen's only name for it
    return packed


def fields_of(lcm_class: Any) -> list[Field]:
    """Return the fields of an lcm-gen class in wire order."""
    columns = zip(lcm_class.__slots__, lcm_class.__typenames__, lcm_class.__dimensions__, strict=True)
    return [_field(lcm_class, name, typename, tuple(dims or ())) for name, typename, dims in columns]


def _field(lcm_class: type, name: str, typename: str, dims: tuple[Dim, ...]) -> Field:
    if typename in PRIMITIVES:
        return Field(name, typename, dims, None)
    struct = _struct(lcm_class, typename)
    return Field(name, lcm_name(struct), dims, struct)


def _struct(lcm_class: type, typename: str) -> type:
    """Return the class of a nested type, resolved as in the generated module, or as `given_types` made it."""
    if (given := vars(lcm_class).get("structs")) is not None:
        lcm_struct: type = given[typename]
        return lcm_struct
    package, *path = typename.split(".")
    found: type = functools.reduce(getattr, path, vars(sys.modules[lcm_class.__module__])[package])
    return found
