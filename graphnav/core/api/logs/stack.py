"""Stack one field of many messages into one array, or their scalars into a table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from graphnav.arrays import Doubles
from graphnav.core.errors import UserError, did_you_mean
from graphnav.core.machine.extras import import_pandas

if TYPE_CHECKING:
    import pandas as pd

MAX_ELEMENTS = 16
"""Arrays with more elements do not become columns."""


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


def table_of(samples: Iterable[tuple[float, Any]]) -> pd.DataFrame:
    """Return one row per message and one column per scalar; omit arrays that change their shape.

    Raises
    ------
    UserError
        pandas is not installed.
    """
    pandas = import_pandas("to_pandas")
    times_s: list[float] = []
    rows: list[dict[str, Any]] = []
    shapes: dict[str, set[tuple[int, ...]]] = {}
    for time_s, message in samples:
        row = dict(_scalars("", fields_of_message(message), shapes))
        times_s.append(time_s)
        rows.append(row)
    changing = tuple(f"{name}[" for name, found in shapes.items() if len(found) > 1)
    names = dict.fromkeys(name for row in rows for name in row if not name.startswith(changing))
    columns = {name: [row.get(name) for row in rows] for name in names}
    return pandas.DataFrame(columns, index=pandas.Index(times_s, name="time_s", dtype="float64"))


def _scalars(
    prefix: str, fields: Mapping[str, Any], shapes: dict[str, set[tuple[int, ...]]]
) -> Iterator[tuple[str, Any]]:
    """Yield the columns of a message; add the shapes of its arrays to ``shapes``."""
    for field, value in fields.items():
        name = f"{prefix}{field}"
        if isinstance(value, Mapping):
            yield from _scalars(f"{name}.", value, shapes)
        elif isinstance(value, np.ndarray):
            shapes.setdefault(name, set()).add(value.shape)
            if value.dtype != object and value.size <= MAX_ELEMENTS:
                for at in np.ndindex(value.shape):
                    yield name + "".join(f"[{index}]" for index in at), value[at].item()
        elif not isinstance(value, tuple) or all(isinstance(item, str) for item in value):
            yield name, value
