"""The scalars of an LCM type, one column each: ``v_mps``, ``pose.x_m``, ``control[0]``."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from graphnav.core.codec import Field, fields_of

Step = str | tuple[int, ...]
"""The name of a field, or an array index."""

Scalar = int | float | bool | str

_MAX_ELEMENTS = 36
"""Arrays of a fixed size up to this, such as forces, are written as one column per element."""


class Leaf(NamedTuple):
    """A scalar of a type: its name, its path, its LCM primitive.

    ``is_size``: whether it is the size of an array.
    """

    name: str
    path: tuple[Step, ...]
    primitive: str
    is_size: bool

    def of(self, fields: Mapping[str, Any]) -> Scalar:
        """Return the value of the scalar in decoded fields."""
        value: Any = fields
        for step in self.path:
            value = value[step] if isinstance(step, str) or isinstance(value, np.ndarray) else value[step[0]]
        scalar: Scalar = value.item() if isinstance(value, np.generic) else value
        return scalar


def leaves_of(lcm_class: type) -> list[Leaf]:
    """Return the scalars of an LCM type in field order, including nested structs and small fixed arrays."""
    return list(_leaves(lcm_class, "", ()))


def has_few_elements(field: Field) -> bool:
    """Whether a field is a scalar, a struct, or a small array of fixed size."""
    return all(isinstance(dim, int) for dim in field.dims) and math.prod(map(int, field.dims)) <= _MAX_ELEMENTS


def _leaves(lcm_class: type, prefix: str, path: tuple[Step, ...]) -> Iterator[Leaf]:
    fields = fields_of(lcm_class)
    sizes = {dim for field in fields for dim in field.dims}
    for field in fields:
        name, step = prefix + field.name, (*path, field.name)
        if not has_few_elements(field):
            continue
        for place in product(*(range(dim) for dim in field.dims if isinstance(dim, int))):
            indexed = name + "".join(f"[{index}]" for index in place)
            steps = (*step, place) if place else step
            if field.struct is not None:
                yield from _leaves(field.struct, f"{indexed}.", steps)
            else:
                yield Leaf(indexed, steps, field.primitive, field.name in sizes)
