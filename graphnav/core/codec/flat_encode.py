"""Generated encoders for one type: the common case, without loops and look-ups.

They cover types of scalars, strings, arrays of numbers and lists of strings. For anything unexpected (another dtype,
sizes that disagree) they return None, and the general codec takes over and reports errors.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np

from graphnav.core.codec.flat_decode import compiled, dtypes, sizes_of
from graphnav.core.codec.layout import PRIMITIVES, Field

FieldEncoder = Callable[[Mapping[str, Any]], bytes | None]
MessageEncoder = Callable[[Any, int, int], bytes | None]
FinitenessCheck = Callable[[Any], bool | None]

_LENGTH = struct.Struct(">I")
_MAX_VECTOR = 8


def field_encoder(fields: list[Field], fingerprint: bytes) -> FieldEncoder:
    """Return a function from a mapping of fields to bytes; it returns None for unexpected fields."""
    sources = {field.name: f"f[{field.name!r}]" for field in fields}
    checks = ["if not known.issuperset(f): return None"]
    checks += _array_checks(fields, sources, "if {dim!r} in f and f[{dim!r}] != {size}: return None")
    encode: FieldEncoder = _encoder("f", fields, sources, fingerprint, checks)
    return encode


def message_encoder(fields: list[Field], fingerprint: bytes) -> MessageEncoder:
    """Return a function from ``(message, utime, seq)`` to bytes, for a message whose attributes are the fields."""
    sources = {field.name: f"m.{field.name}" for field in fields} | {"utime": "utime", "seq": "seq"}
    encode: MessageEncoder = _encoder("m, utime, seq", fields, sources, fingerprint, _array_checks(fields, sources))
    return encode


def finiteness_check(fields: list[Field], checked: Collection[str]) -> FinitenessCheck:
    """Return a function from a message: True if the floats among its ``checked`` fields are surely finite.

    The sum of an array's squares is finite if all elements are, unless it overflows.
    """
    conditions = [
        f"isfinite(vdot(x := m.{field.name}.ravel('K'), x))" if field.dims else f"isfinite(m.{field.name})"
        for field in fields
        if field.name in checked and field.primitive in {"float", "double"}
    ]
    body = [f"return {' and '.join(conditions) or True}"]
    check: FinitenessCheck = compiled("m", body, {"isfinite": math.isfinite, "vdot": np.vdot})
    return check


def _array_checks(fields: list[Field], sources: Mapping[str, str], given: str = "") -> list[str]:
    """Return the lines that set ``x0, x1, ..`` to the arrays and check them; ``given`` checks a size that is given."""
    sizes = _size_variables(fields)
    lines: list[str] = []
    bound: set[str] = set()
    for place, field in enumerate(field for field in fields if field.dims):
        axes = [f"a{place}_{axis}" for axis in range(len(field.dims))]
        lines.append(f"x{place} = {sources[field.name]}")
        if field.primitive == "string":
            lines += [f"if type(x{place}) is not tuple: return None", f"{axes[0]} = len(x{place})"]
        else:
            lines += [
                f"if type(x{place}) is not ndarray or x{place}.dtype is not native_{field.primitive}: return None",
                f"{', '.join(axes)}, = x{place}.shape",
            ]
        for axis, dim in zip(axes, field.dims, strict=True):
            if isinstance(dim, str) and dim not in bound:
                bound.add(dim)
                lines += [f"{sizes[dim]} = {axis}", *([given.format(dim=dim, size=axis)] if given else [])]
            else:
                lines.append(f"if {axis} != {sizes[dim] if isinstance(dim, str) else dim}: return None")
    return lines


def _encoder(
    arguments: str, fields: list[Field], sources: Mapping[str, str], fingerprint: bytes, checks: list[str]
) -> Any:
    """Return the function that makes the ``checks`` and joins the parts; the fingerprint is packed with scalars."""
    names: dict[str, Any] = {
        "known": frozenset(field.name for field in fields),
        "ndarray": np.ndarray,
        "join": b"".join,
        "strings": _strings,
        "fp": fingerprint,
    }
    names |= {f"native_{f.primitive}": dtypes(f)[0] for f in fields if f.dims and f.primitive != "string"}
    values = {**sources, **_size_variables(fields)}
    pieces: list[str] = []
    codes, scalars, n_arrays = "8s", ["fp"], 0

    def end_scalars() -> None:
        if codes:
            names[f"pack{len(pieces)}"] = struct.Struct(">" + codes).pack
            pieces.append(f"pack{len(pieces)}({', '.join(scalars)})")

    for field in fields:
        if not field.dims and field.primitive != "string":
            codes += PRIMITIVES[field.primitive]
            scalars.append(values[field.name])
            continue
        if _is_vector(field):
            codes += f"{field.dims[0]}d"
            scalars.append(f"*x{n_arrays}.tolist()")
            n_arrays += 1
            continue
        end_scalars()
        codes, scalars = "", []
        if field.primitive == "string":
            pieces.append(f"strings(x{n_arrays})" if field.dims else f"strings(({values[field.name]},))")
        else:
            native, names[f"wire_{field.primitive}"] = dtypes(field)
            converted = "" if native.itemsize == 1 else f".astype(wire_{field.primitive}, 'C')"
            pieces.append(f"x{n_arrays}{converted}")
        n_arrays += bool(field.dims)
    end_scalars()
    result = pieces[0] if len(pieces) == 1 else f"join(({', '.join(pieces)}))"
    return compiled(arguments, [*checks, f"return {result}"], names)


def _is_vector(field: Field) -> bool:
    """Whether it is an array of a few doubles, which are packed like scalars."""
    return field.primitive == "double" and len(field.dims) == 1 and field.dims[0] in range(1, _MAX_VECTOR + 1)


def _size_variables(fields: list[Field]) -> dict[str, str]:
    return {dim: f"n{place}" for place, dim in enumerate(sorted(sizes_of(fields)))}


def _strings(values: tuple[str, ...]) -> bytes:
    """Return strings in wire format: length, UTF-8 and a NUL."""
    encoded = [value.encode("utf-8") for value in values]
    return b"".join([part for one in encoded for part in (_LENGTH.pack(len(one) + 1), one, b"\0")])
