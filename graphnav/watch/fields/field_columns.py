"""Select fields of an LCM type by paths, as table columns or as values, with errors for unknown fields."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from graphnav import Place, UserError, did_you_mean
from graphnav.core.codec import Field, fields_of, lcm_name
from graphnav.watch.fields.field_path import MISSING, FieldPath, Index, Step, path_of

_MAX_COLUMNS = 1000
_MAX_SMALL = 16
"""Arrays of a fixed size up to this have a column per element by default."""
_MAX_DEPTH = 16
_PLACE = Place("--field")


def columns_of(path: FieldPath, lcm_class: type) -> list[FieldPath]:
    """Return a path for each number or string within a path.

    Raises
    ------
    UserError
        The type does not have this field, or its number of elements varies between messages.
    """
    field = _last(path, lcm_class)
    indices = _choices(field, path.steps[-1].indices)
    if indices is None:
        depth = max(axis for axis, dim in enumerate(field.dims) if isinstance(dim, str))
        first = field.name + "[0]" * depth
        hint = f"name elements, {first}[0] or {first}[0:8], or use --jsonl --full"
        raise UserError.of(f"'{path.text}' has no fixed number of elements, so no columns", hint, _PLACE)
    if math.prod(map(len, indices)) > _MAX_COLUMNS:
        raise UserError.of(f"'{path.text}' needs more than {_MAX_COLUMNS} columns", "use --jsonl --full", _PLACE)
    columns: list[FieldPath] = []
    for steps in _elements(path.steps, indices):
        columns += [path_of(steps)] if field.struct is None else all_columns(field.struct, steps)[0]
    return columns


def all_columns(lcm_class: type, steps: tuple[Step, ...] = ()) -> tuple[list[FieldPath], list[str]]:
    """Return paths of all scalars and of the elements of small arrays, and the names of omitted fields.

    ``steps``: the path of the nested type in a message.
    """
    columns: list[FieldPath] = []
    left_out: list[str] = []
    for field in fields_of(lcm_class):
        here = (*steps, Step(field.name))
        indices = _choices(field, ())
        if indices is None or math.prod(map(len, indices)) > _MAX_SMALL or len(here) > _MAX_DEPTH:
            left_out.append(path_of(here).text)
            continue
        for element in _elements(here, indices):
            if field.struct is None:
                columns.append(path_of(element))
            else:
                below, left_out_below = all_columns(field.struct, element)
                columns += below
                left_out += left_out_below
    return columns, left_out


def _last(path: FieldPath, lcm_class: type) -> Field:
    """Return the last field of a path; raises UserError, listing the existing fields, if the type does not have it."""
    inside = lcm_class
    for number, step in enumerate(path.steps, start=1):
        fields = {field.name: field for field in fields_of(inside)}
        field = fields.get(step.name)
        if field is None:
            hint = did_you_mean(step.name, fields) or f"its fields are {', '.join(fields)}"
            raise UserError.of(f"{lcm_name(inside)} has no field '{step.name}'", hint, _PLACE)
        _check_indices(path, step, field)
        if number == len(path.steps):
            return field
        if field.struct is None:
            what = f"'{path.text}': {step.name} is {_kind(field)}, which has no fields"
            raise UserError.of(what, f"write {path_of(path.steps[:number]).text}", _PLACE)
        if len(step.indices) < len(field.dims) or any(isinstance(index, slice) for index in step.indices):
            what = f"'{path.text}': {step.name} is an array of {field.primitive}"
            raise UserError.of(what, f"name one element: {step.name}{'[0]' * len(field.dims)}", _PLACE)
        inside = field.struct
    raise AssertionError(path)


def _check_indices(path: FieldPath, step: Step, field: Field) -> None:
    if len(step.indices) > len(field.dims):
        axes = f"{len(field.dims)} {'axis' if len(field.dims) == 1 else 'axes'}" if field.dims else "no elements"
        what = f"'{path.text}': {step.name} is {_kind(field)} and has {axes}"
        raise UserError.of(what, f"write {step.name}{'[0]' * len(field.dims)}", _PLACE)
    for dim, index in zip(field.dims, step.indices, strict=False):
        if isinstance(dim, int) and isinstance(index, int) and not -dim <= index < dim:
            what = f"'{path.text}': {step.name} is {_kind(field)}"
            raise UserError.of(what, f"its elements on this axis are 0 to {dim - 1}", _PLACE)


def _kind(field: Field) -> str:
    return field.primitive + "".join(f"[{dim}]" for dim in field.dims)


def _choices(field: Field, indices: tuple[Index, ...]) -> list[Sequence[int]] | None:
    """Return the indices on each axis of an array, None if their number varies between messages."""
    found = [_on_axis(dim, index) for dim, index in itertools.zip_longest(field.dims, indices)]
    known = [elements for elements in found if elements is not None]
    return known if len(known) == len(found) else None


def _on_axis(dim: int | str, index: Index | None) -> Sequence[int] | None:
    if isinstance(index, int):
        return [index]
    if isinstance(dim, int):
        return range(dim)[index] if index is not None else range(dim)
    if index is None or index.stop is None or index.stop < 0 or (index.start or 0) < 0:
        return None
    return range(index.start or 0, index.stop, index.step or 1)


def _elements(steps: tuple[Step, ...], indices: list[Sequence[int]]) -> Iterator[tuple[Step, ...]]:
    *before, last = steps
    for element in itertools.product(*indices):
        yield (*before, Step(last.name, element))


class Selection:
    """The fields of messages selected by paths, all fields without paths.

    The first message determines the type; with paths, messages of other types are skipped.
    """

    def __init__(self, paths: Sequence[FieldPath]) -> None:
        self._paths = paths
        self._lcm_class: type | None = None

    def of(self, lcm_class: type, values: Mapping[str, Any]) -> Mapping[str, Any] | None:
        """Return the selected values of a message, by path; None for a message of another type than the first.

        Missing elements are None. Raises UserError if the first type does not have a field.
        """
        if not self._paths:
            return values
        if self._lcm_class is None:
            for path in self._paths:
                _last(path, lcm_class)
            self._lcm_class = lcm_class
        if lcm_class is not self._lcm_class:
            return None
        picked = {path.text: path.pick(values) for path in self._paths}
        return {text: None if value is MISSING else value for text, value in picked.items()}
