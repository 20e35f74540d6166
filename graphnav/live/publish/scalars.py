"""Check single values of LCM messages against their primitive type."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from graphnav import Problem, Value

_INTEGERS: Mapping[str, tuple[int, int]] = {
    "int8_t": (-(2**7), 2**7 - 1),
    "int16_t": (-(2**15), 2**15 - 1),
    "int32_t": (-(2**31), 2**31 - 1),
    "int64_t": (-(2**63), 2**63 - 1),
    "byte": (0, 255),
}
_FLOAT_MAX = float(np.finfo(np.float32).max)

ZEROS: Mapping[str, Any] = {**dict.fromkeys(_INTEGERS, 0), "float": 0.0, "double": 0.0, "boolean": False, "string": ""}
"""Value of a field that is not given."""


def scalar_problem(name: str, primitive: str, value: Value) -> Problem | None:
    """Return the problem with the value of a field, None if it matches the type."""
    data = value.data
    if primitive in _INTEGERS:
        return _integer_problem(name, primitive, value)
    if primitive == "boolean":
        fits, wanted, hint = isinstance(data, bool), "a boolean", "write true or false"
    elif primitive == "string":
        hint = "put it in quotes" if isinstance(data, bool | int | float) else "write a string"
        fits, wanted = isinstance(data, str), "a string"
    else:
        fits, wanted, hint = (
            isinstance(data, int | float) and not isinstance(data, bool),
            f"a number ({primitive})",
            "write a number",
        )
    if not fits:
        return Problem(value.place, f"'{name}' must be {wanted}, not {value.kind}", hint)
    if primitive in {"float", "double"} and isinstance(data, int | float):
        if not math.isfinite(data):
            return Problem(value.place, f"'{name}' is not finite: {data}", "write a finite number")
        if primitive == "float" and abs(data) > _FLOAT_MAX:
            return Problem(
                value.place,
                f"'{name}' is {data}, but the maximum of float is {_FLOAT_MAX:.6g}",
                "write a smaller number",
            )
    return None


def _integer_problem(name: str, primitive: str, value: Value) -> Problem | None:
    data, (smallest, largest) = value.data, _INTEGERS[primitive]
    if isinstance(data, bool) or not isinstance(data, int):
        what = f"'{name}' must be an integer ({primitive}), not {value.kind}"
        return Problem(value.place, what, "write an integer")
    if not smallest <= data <= largest:
        what = f"'{name}' is {data}, but the range of {primitive} is {smallest} to {largest}"
        return Problem(value.place, what, "write an integer in this range")
    return None
