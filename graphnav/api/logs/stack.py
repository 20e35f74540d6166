"""One field of many messages as one array."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from graphnav.arrays import Doubles
from graphnav.errors import UserError, did_you_mean


class Stack(NamedTuple):
    """Times and values; unpack it."""

    times_s: Doubles
    """float64 (n,): seconds since the log began."""
    values: npt.NDArray[Any]
    """(n, ...): the field's own shape and type behind the messages."""


def fields_of_message(message: Any) -> Mapping[str, Any]:
    """Return the fields of a message, or of the dict that stands for one of another package."""
    if isinstance(message, Mapping):
        return {name: value for name, value in message.items() if name not in {"utime", "seq"}}
    return {name: getattr(message, name) for name in message.__dataclass_fields__}


def stacked(samples: Iterable[tuple[float, Any]], most: int, channel: str, field: str) -> Stack:
    """Return a field of ``samples``, of which there are at most ``most``.

    Raises
    ------
    UserError
        There is no such field, it does not hold numbers, or its shape changes.
    """
    times_s = np.empty(most)
    values: npt.NDArray[Any] | None = None
    n = 0
    for time_s, message in samples:
        value = _numbers(message, channel, field)
        if values is None:
            values = np.empty((most, *value.shape), value.dtype)
        elif value.shape != values.shape[1:]:
            what = f"'{field}' of '{channel}' has shape {values.shape[1:]} first, and {value.shape} at {time_s:g} s"
            raise UserError.of(what, "choose start_s and end_s so that all are alike, or read them one by one")
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
    raise UserError.of(f"'{field}' of '{channel}' does not hold numbers", "read the messages one by one")
