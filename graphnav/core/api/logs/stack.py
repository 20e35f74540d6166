"""Stack one field of many messages into one array."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from graphnav.arrays import Doubles
from graphnav.core.errors import UserError, did_you_mean


class Stack(NamedTuple):
    """Times and values, to be unpacked."""

    times_s: Doubles
    """float64 (n,): seconds from the start of the log."""
    values: npt.NDArray[Any]
    """(n, ...): messages first, then the field's own shape and type."""


def fields_of_message(message: Any) -> Mapping[str, Any]:
    """Return the fields of a message, or of the dict that represents a third-party one."""
    if isinstance(message, Mapping):
        return {name: value for name, value in message.items() if name not in {"utime", "seq"}}
    return {name: getattr(message, name) for name in message.__dataclass_fields__}


def stacked(samples: Iterable[tuple[float, Any]], max_count: int, channel: str, field: str) -> Stack:
    """Return a field of at most ``max_count`` ``samples``.

    Raises
    ------
    UserError
        The field does not exist, is not numeric, or changes its shape.
    """
    times_s = np.empty(max_count)
    values: npt.NDArray[Any] | None = None
    n = 0
    for time_s, message in samples:
        value = _numbers(message, channel, field)
        if values is None:
            values = np.empty((max_count, *value.shape), value.dtype)
        elif value.shape != values.shape[1:]:
            what = f"'{field}' of '{channel}' has shape {values.shape[1:]} first, and {value.shape} at {time_s:g} s"
            raise UserError.of(
                what, "choose start_s and end_s so that all shapes are equal, or read messages one by one"
            )
        times_s[n], values[n] = time_s, value
        n += 1
    return Stack(times_s[:n], np.empty((0,)) if values is None else values[:n])


def _numbers(message: Any, channel: str, field: str) -> npt.NDArray[Any]:
    fields = fields_of_message(message)
    if field not in fields:
        hint = did_you_mean(field, fields) or f"it has {', '.join(fields)}"
        raise UserError.of(f"'{channel}' has no field '{field}'", hint)
    if isinstance(fields[field], np.ndarray | np.generic | bool | int | float):
        return np.asarray(fields[field])
    raise UserError.of(f"'{field}' of '{channel}' is not numeric", "read the messages one by one")
