"""The scalars of an LCM type, one column each: ``v_mps``, ``pose.x_m``, ``control[0]``."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from graphnav.codec import fields_of
from graphnav.codec.layout import Field

Step = str | tuple[int, ...]
"""The name of a field, or the place in an array."""

Scalar = int | float | bool | str

MAX_ELEMENTS = 36
"""An array of a fixed size up to this, a force or a covariance, is as many columns."""


class Leaf(NamedTuple):
    """A scalar of a type: its name as people write it, the way to it, its LCM primitive.

    ``is_size``: whether it is but the size of an array.
    """

    name: str
    path: tuple[Step, ...]
    primitive: str
    is_size: bool

    def of(self, fields: Mapping[str, Any]) -> Scalar:
        """Return the scalar that the decoded fields of a message hold."""
        value: Any = fields
        for step in self.path:
            value = value[step] if isinstance(step, str) or isinstance(value, np.ndarray) else value[step[0]]
        scalar: Scalar = value.item() if isinstance(value, np.generic) else value
        return scalar


def leaves_of(lcm_class: type) -> list[Leaf]:
    """Return the scalars of an LCM type in the order of its fields: nested structs and small fixed arrays too."""
    return list(_leaves(lcm_class, "", ()))


def has_few_elements(field: Field) -> bool:
    """Whether a field is a scalar or a struct, or an array of few whose size the type fixes."""
    return all(isinstance(dim, int) for dim in field.dims) and math.prod(map(int, field.dims)) <= MAX_ELEMENTS


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
