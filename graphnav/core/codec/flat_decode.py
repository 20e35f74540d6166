"""Generated decoders for one type: the common case, without loops and look-ups.

They cover types of scalars, strings, arrays of numbers and lists of strings. For damaged bytes they return None, and
the general codec takes over and reports errors.
"""

from __future__ import annotations

import itertools
import struct
from collections.abc import Callable
from typing import Any

import numpy as np

from graphnav.core.codec.errors import DecodeError
from graphnav.core.codec.field_codecs import read_strings
from graphnav.core.codec.layout import PRIMITIVES, Field
from graphnav.core.messages import ZERO_MEANS

FieldDecoder = Callable[[bytes], dict[str, Any] | None]
MessageDecoder = Callable[[bytes], tuple[int, int, Any] | None]
Measure = Callable[[bytes], bool | None]

_MAX_SIDE = 1 << 28
_MISFITS = (struct.error, KeyError, TypeError, ValueError, AttributeError, OverflowError, BufferError, DecodeError)


def is_flat(fields: list[Field]) -> bool:
    """Whether a type has only scalars, strings, arrays of numbers and lists of strings."""
    return bool(fields) and all(
        f.struct is None and 0 not in f.dims and (f.primitive != "string" or len(f.dims) < 2) for f in fields
    )


def field_decoder(fields: list[Field], fingerprint: bytes) -> FieldDecoder:
    """Return a function from bytes to a dict of fields; it returns None for unexpected bytes."""
    variables = _variables(fields)
    names: dict[str, Any] = {}
    body = _reading(fields, fingerprint, names)
    body.append(f"return {{{', '.join(f'{name!r}: {v}' for name, v in variables.items())}}}")
    decode: FieldDecoder = compiled("d", body, names)
    return decode


def message_decoder(
    fields: list[Field], fingerprint: bytes, message_class: type, attributes: tuple[str, ...]
) -> MessageDecoder:
    """Return a function from bytes to ``(utime, seq, message)``; it returns None for unexpected bytes.

    The message is made by setting ``attributes``, without a call of its constructor.
    """
    variables = _variables(fields)
    names: dict[str, Any] = {"cls": message_class, "new": object.__new__, "set": object.__setattr__}
    body = _reading(fields, fingerprint, names)
    values = {name: f"{variables[name]} or {ZERO_MEANS[name]}" for name in attributes if name in ZERO_MEANS}
    items = ", ".join(f"{name!r}: {values.get(name, variables[name])}" for name in attributes)
    body += ["m = new(cls)", f"set(m, '__dict__', {{{items}}})"]
    body.append(f"return {variables['utime']}, {variables['seq']}, m")
    decode: MessageDecoder = compiled("d", body, names)
    return decode


def _reading(fields: list[Field], fingerprint: bytes, names: dict[str, Any]) -> list[str]:
    """Return the lines that set a variable for each field; adds what they need to ``names``.

    Adjacent arrays of one type are converted together.
    """
    variables = _variables(fields)
    names |= {"frombuffer": np.frombuffer, "strings": read_strings, "fp": fingerprint}
    body = []
    if fields[0].dims or fields[0].primitive == "string":
        body = ["if d[:8] != fp: return None", "end = 8"]
    for run, (kind, group) in enumerate(itertools.groupby(fields, _kind)):
        members = list(group)
        if not body:
            packer = names["head"] = struct.Struct(f">8s{packer_of(members).format[1:]}")
            targets = ", ".join(variables[field.name] for field in members)
            body = [f"found, {targets} = head.unpack_from(d)", "if found != fp: return None", f"end = {packer.size}"]
        elif kind == "scalar":
            packer = names[f"scalars{run}"] = packer_of(members)
            targets = "".join(f"{variables[field.name]}, " for field in members)
            body += [f"{targets}= scalars{run}.unpack_from(d, end)", f"end += {packer.size}"]
        elif kind == "string":
            for field in members:
                v = variables[field.name]
                count = _shape(field, variables)[0] if field.dims else "1"
                body.append(f"{v}, end = strings(d, end, {count})")
                if not field.dims:
                    body.append(f"{v}, = {v}")
        else:
            body += _arrays(members, variables, f"r{run}", names)
    return [*body, "if end != len(d): return None"]


def _arrays(members: list[Field], variables: dict[str, str], run: str, names: dict[str, Any]) -> list[str]:
    """Return the lines that read adjacent arrays of one type."""
    native, names[f"wire_{run}"] = dtypes(members[0])
    names[f"native_{run}"], names[f"none_{run}"] = native, np.empty(0, native)
    names[f"none_{run}"].setflags(write=False)
    body: list[str] = []
    shapes = {field.name: _shape(field, variables) for field in members}
    sides = dict.fromkeys(side for shape in shapes.values() for side in shape if not side.isdigit())
    body += [f"if {side} < 0: return None" for side in sides]
    counts = [" * ".join(shapes[field.name]) for field in members]
    body += [
        f"count = {' + '.join(counts)}",
        f"if end + count * {native.itemsize} > len(d): return None",
        f"{run} = frombuffer(d, wire_{run}, count, end) if count else none_{run}",
        f"end += count * {native.itemsize}",
    ]
    if native.itemsize > 1:
        body.append(f"{run} = {run}.astype(native_{run})")
    body.append(f"{run}.setflags(write=False)")
    if len(members) == 1:
        (field,) = members
        return [*body, f"{variables[field.name]} = {run}{_reshape(shapes[field.name])}"]
    body.append("at = 0")
    for field, count in zip(members, counts, strict=True):
        part = f"{run}[at : at + {count}]"
        body += [f"{variables[field.name]} = {part}{_reshape(shapes[field.name])}", f"at += {count}"]
    return body


def measure(fields: list[Field], fingerprint: bytes) -> Measure:
    """Return a predicate: whether the bytes have the length that their size fields announce; None means no.

    For types without strings.
    """
    variables, sizes = _variables(fields), sizes_of(fields)
    names: dict[str, Any] = {"fp": fingerprint, "max_side": _MAX_SIDE}
    body = ["if d[:8] != fp: return False", "end = 8"]
    for run, (is_scalar, group) in enumerate(itertools.groupby(fields, lambda field: not field.dims)):
        if is_scalar:
            scalars = list(group)
            packer = names[f"scalars{run}"] = packer_of(scalars)
            if any(field.name in sizes for field in scalars):
                body.append(f"{''.join(f'{variables[f.name]}, ' for f in scalars)}= scalars{run}.unpack_from(d, end)")
            body.append(f"end += {packer.size}")
            continue
        for field in group:
            body += [f"if not 0 <= {variables[dim]} <= max_side: return False" for dim in field.dims if dim in sizes]
            body.append(f"end += {' * '.join(_shape(field, variables))} * {dtypes(field)[0].itemsize}")
    body.append("return end == len(d)")
    measures: Measure = compiled("d", body, names)
    return measures


def compiled(arguments: str, body: list[str], names: dict[str, Any]) -> Any:
    """Return the compiled function; it returns None for anything outside of its fast path."""
    lines = [f"def move({arguments}):", " try:", *(f"  {line}" for line in body), " except misfits:", "  return None"]
    names["misfits"] = _MISFITS
    exec("\n".join(lines), names)  # noqa: S102 - every word of it comes from an lcm-gen class
    return names["move"]


def packer_of(scalars: list[Field]) -> struct.Struct:
    """Return the packer of adjacent scalars."""
    return struct.Struct(">" + "".join(PRIMITIVES[field.primitive] for field in scalars))


def dtypes(field: Field) -> tuple[np.dtype[Any], np.dtype[Any]]:
    """Return the dtype of an array of numbers in memory and on the wire."""
    native = np.dtype(PRIMITIVES[field.primitive].replace("q", "i8"))
    return native, native.newbyteorder(">") if native.itemsize > 1 else native


def sizes_of(fields: list[Field]) -> set[str]:
    """Return the names of the fields that hold sizes of arrays."""
    return {dim for field in fields for dim in field.dims if isinstance(dim, str)}


def _kind(field: Field) -> str:
    """Return what adjacent fields must have in common to be read together."""
    if field.primitive == "string":
        return "string"
    return field.primitive if field.dims else "scalar"


def _variables(fields: list[Field]) -> dict[str, str]:
    return {field.name: f"v{place}" for place, field in enumerate(fields)}


def _shape(field: Field, variables: dict[str, str]) -> list[str]:
    return [str(dim) if isinstance(dim, int) else variables[dim] for dim in field.dims]


def _reshape(shape: list[str]) -> str:
    return "" if len(shape) == 1 else f".reshape(({', '.join(shape)}))"
