"""The messages of a channel as a DataFrame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from graphnav.core.api.logs.stack import fields_of_message
from graphnav.core.machine.extras import import_pandas

if TYPE_CHECKING:
    import pandas as pd

MAX_ELEMENTS = 16
"""Arrays with more elements do not become columns."""


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
