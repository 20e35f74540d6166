"""Generated encoders and decoders for one type: the common case, without loops and look-ups.

They cover types of scalars and arrays of numbers. For anything unexpected (another dtype, sizes that disagree, damaged
bytes) they return None, and the general codec takes over and reports errors.
"""

from __future__ import annotations

import itertools
import struct
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from graphnav.codec.layout import PRIMITIVES, Field

FlatEncoder = Callable[[Mapping[str, Any]], bytes | None]
FlatDecoder = Callable[[bytes], dict[str, Any] | None]
FlatMeasure = Callable[[bytes], bool | None]

_MAX_SIDE = 1 << 28
_MISFITS = (struct.error, KeyError, TypeError, ValueError, AttributeError, OverflowError)


def is_flat(fields: list[Field]) -> bool:
    """Whether a type has only scalars and arrays of numbers."""
    return bool(fields) and all(f.struct is None and f.primitive != "string" and 0 not in f.dims for f in fields)


def flat_encoder(fields: list[Field], fingerprint: bytes) -> FlatEncoder:
    """Return a function from fields to bytes; it returns None for unexpected fields."""
    known = frozenset(field.name for field in fields)
    sizes = {dim: f"n{place}" for place, dim in enumerate(sorted(_sizes(fields)))}
    names: dict[str, Any] = {
        "ndarray": np.ndarray,
        "contiguous": np.ascontiguousarray,
        "fp": fingerprint,
        "known": known,
    }
    checks, pieces = ["if not known.issuperset(f): return None"], ["fp"]
    bound: set[str] = set()
    for place, field in enumerate(field for field in fields if field.dims):
        names[f"native{place}"], names[f"wire{place}"] = _dtypes(field)
        axes = [f"a{place}_{axis}" for axis in range(len(field.dims))]
        checks += [
            f"x{place} = f[{field.name!r}]",
            f"if type(x{place}) is not ndarray or x{place}.dtype is not native{place}: return None",
            f"{', '.join(axes)}, = x{place}.shape",
        ]
        for axis, dim in zip(axes, field.dims, strict=True):
            if isinstance(dim, str) and dim not in bound:
                bound.add(dim)
                checks += [f"{sizes[dim]} = {axis}", f"if {dim!r} in f and f[{dim!r}] != {axis}: return None"]
            else:
                checks.append(f"if {axis} != {sizes.get(dim, dim)}: return None")  # type: ignore[arg-type]
    arrays = itertools.count()
    for run, (is_scalar, group) in enumerate(itertools.groupby(fields, lambda field: not field.dims)):
        if is_scalar:
            scalars = list(group)
            names[f"pack{run}"] = _packer(scalars).pack
            values = ", ".join(sizes.get(field.name) or f"f[{field.name!r}]" for field in scalars)
            pieces.append(f"pack{run}({values})")
        else:
            for place in itertools.islice(arrays, len(list(group))):
                one_byte = names[f"native{place}"].itemsize == 1
                array = f"contiguous(x{place})" if one_byte else f"x{place}.astype(wire{place}, 'C')"
                pieces.append(array)
    body = [*checks, f"return b''.join(({', '.join(pieces)},))"]
    encode: FlatEncoder = _function("f", body, names)
    return encode


def flat_decoder(fields: list[Field], fingerprint: bytes) -> FlatDecoder:
    """Return a function from bytes to fields; it returns None for unexpected bytes."""
    variables = {field.name: f"v{place}" for place, field in enumerate(fields)}
    names: dict[str, Any] = {"frombuffer": np.frombuffer, "fp": fingerprint}
    body = ["if d[:8] != fp: return None", "end = 8"]
    for run, (is_scalar, group) in enumerate(itertools.groupby(fields, lambda field: not field.dims)):
        if is_scalar:
            scalars = list(group)
            packer = names[f"scalars{run}"] = _packer(scalars)
            targets = "".join(f"{variables[field.name]}, " for field in scalars)
            body += [f"{targets}= scalars{run}.unpack_from(d, end)", f"end += {packer.size}"]
            continue
        for field in group:
            v = variables[field.name]
            native, names[f"wire_{v}"] = _dtypes(field)
            names[f"native_{v}"], names[f"none_{v}"] = native, np.empty(0, native)
            dims = [str(dim) if isinstance(dim, int) else variables[dim] for dim in field.dims]
            body += [f"if {variables[dim]} < 0: return None" for dim in field.dims if isinstance(dim, str)]
            body += [
                f"count = {' * '.join(dims)}",
                f"if end + count * {native.itemsize} > len(d): return None",
                f"{v} = (frombuffer(d, wire_{v}, count, end) if count else none_{v}).reshape(({', '.join(dims)},))",
            ]
            if native.itemsize > 1:
                body.append(f"{v} = {v}.astype(native_{v})")
            body.append(f"{v}.setflags(write=False)")
            body.append(f"end += count * {native.itemsize}")
    result = ", ".join(f"{name!r}: {v}" for name, v in variables.items())
    body += ["if end != len(d): return None", f"return {{{result}}}"]
    decode: FlatDecoder = _function("d", body, names)
    return decode


def flat_measure(fields: list[Field], fingerprint: bytes) -> FlatMeasure:
    """Return a predicate: whether the bytes have the length that their size fields announce; None means no."""
    variables = {field.name: f"v{place}" for place, field in enumerate(fields)}
    sizes = _sizes(fields)
    names: dict[str, Any] = {"fp": fingerprint, "max_side": _MAX_SIDE}
    body = ["if d[:8] != fp: return False", "end = 8"]
    for run, (is_scalar, group) in enumerate(itertools.groupby(fields, lambda field: not field.dims)):
        if is_scalar:
            scalars = list(group)
            packer = names[f"scalars{run}"] = _packer(scalars)
            if any(field.name in sizes for field in scalars):
                body.append(f"{''.join(f'{variables[f.name]}, ' for f in scalars)}= scalars{run}.unpack_from(d, end)")
            body.append(f"end += {packer.size}")
            continue
        for field in group:
            dims = [str(dim) if isinstance(dim, int) else variables[dim] for dim in field.dims]
            body += [f"if not 0 <= {variables[dim]} <= max_side: return False" for dim in field.dims if dim in sizes]
            body.append(f"end += {' * '.join(dims)} * {_dtypes(field)[0].itemsize}")
    body.append("return end == len(d)")
    measure: FlatMeasure = _function("d", body, names)
    return measure


def _function(argument: str, body: list[str], names: dict[str, Any]) -> Any:
    """Return the compiled function; it returns None for anything outside of its fast path."""
    lines = [f"def move({argument}):", " try:", *(f"  {line}" for line in body), " except misfits:", "  return None"]
    names["misfits"] = _MISFITS
    exec("\n".join(lines), names)  # noqa: S102 - every word of it comes from an lcm-gen class
    return names["move"]


def _packer(scalars: list[Field]) -> struct.Struct:
    return struct.Struct(">" + "".join(PRIMITIVES[field.primitive] for field in scalars))


def _dtypes(field: Field) -> tuple[np.dtype[Any], np.dtype[Any]]:
    native = np.dtype(PRIMITIVES[field.primitive].replace("q", "i8"))
    return native, native.newbyteorder(">")


def _sizes(fields: list[Field]) -> set[str]:
    return {dim for field in fields for dim in field.dims if isinstance(dim, str)}
