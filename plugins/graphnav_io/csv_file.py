"""Read the columns of a csv file; errors name the line."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from graphnav import ParamError, read_regular
from graphnav.arrays import Doubles, Longs

TIME_UNITS = {"s": 1e6, "ms": 1e3, "us": 1.0, "ns": 1e-3}
"""Suffixes of columns of times, and microseconds in each."""
TIMES = ("utime", "time", "timestamp", "stamp", "t")
"""Names of columns of times, which a suffix may follow."""
MAX_BYTES = 256 * 1024**2
"""Of a csv file: more than an hour of odometry at 1 kHz."""
MAX_US = 3e18
"""A larger time, in microseconds, is none: it is later than the year 90000."""
MAX_SECONDS = 1e11
"""A larger time is not in seconds: it is the year 5138."""


class CsvFile:
    """A csv file with a header.

    Names are compared in lower case, without ``#`` and spaces, and with a unit in brackets as a suffix: ``#timestamp
    [ns]`` is timestamp_ns.

    Raises
    ------
    ParamError
        The file cannot be read, has no rows, or has a row of another length; names the parameter ``param``.
    """

    def __init__(self, param: str, path: Path) -> None:
        self._param, self._path = param, path
        try:
            text = read_regular(path, MAX_BYTES).decode("utf-8-sig")
            reader = csv.reader(io.StringIO(text, newline=""))
            self.names = [_name(name) for name in next(reader, [])]
            self._rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
        except OSError as error:
            raise ParamError(param, f"'{path}' cannot be read: {error.strerror}", "give a csv file") from error
        except (UnicodeDecodeError, csv.Error) as error:
            raise ParamError(param, f"'{path}' is not a csv file", "write columns with commas between them") from error
        if not self._rows:
            raise ParamError(param, f"'{path}' holds no rows", "write a header and a row for each time")
        for line, row in self._rows:
            if len(row) != len(self.names):
                what = f"{len(row)} columns, but the header has {len(self.names)}"
                raise self.fault(line, what, "write a value for every column")

    def fault(self, line: int, what: str, hint: str) -> ParamError:
        """Return the error of a line."""
        return ParamError(self._param, f"{self._path}:{line}: {what}", hint)

    def find(self, names: Iterable[str]) -> str | None:
        """Return the first of ``names`` that is a column."""
        return next((name for name in names if name in self.names), None)

    def time_column(self) -> str | None:
        """Return the column of times: a known name, with or without the suffix of a unit."""
        return self.find(f"{name}{suffix}" for name in TIMES for suffix in ("", *(f"_{unit}" for unit in TIME_UNITS)))

    def words(self, name: str) -> list[str]:
        """Return the cells of a column as strings."""
        place = self.names.index(name)
        return [row[place].strip() for _, row in self._rows]

    def numbers(self, name: str) -> Doubles:
        """Return the numbers of a column.

        Raises
        ------
        ParamError
            A cell is not a finite number.
        """
        values = []
        for (line, _), word in zip(self._rows, self.words(name), strict=True):
            try:
                values.append(float(word))
            except ValueError:
                values.append(math.nan)
            if not math.isfinite(values[-1]):
                raise self.fault(line, f"'{name}' is '{word}', not a finite number", "correct the line, or remove it")
        return np.array(values)

    def utimes(self, name: str) -> Longs:
        """Return the times of a column in microseconds; the suffix of its name is the unit, seconds without one.

        Raises
        ------
        ParamError
            A cell is not a number, a time is not later than the one before, is larger than `MAX_US`, or its unit
            cannot be seconds.
        """
        values = self.numbers(name)
        unit = "us" if name == "utime" else name.rpartition("_")[2]
        if unit not in TIME_UNITS and np.abs(values).max() > MAX_SECONDS:
            line, _ = self._rows[int(np.argmax(np.abs(values)))]
            what = f"'{name}' is {self.words(name)[int(np.argmax(np.abs(values)))]}, which cannot be seconds"
            raise self.fault(line, what, f"name the column {name}_ms, {name}_us or {name}_ns, by its unit")
        scale = TIME_UNITS.get(unit, TIME_UNITS["s"])
        for k in np.flatnonzero(np.abs(values) > MAX_US / scale):
            line, _ = self._rows[k]
            raise self.fault(line, f"'{name}' is {self.words(name)[k]}, which is not a time", "correct the line")
        found = np.rint(values * scale).astype(np.int64)
        for k in np.flatnonzero(np.diff(found) <= 0):
            line, _ = self._rows[k + 1]
            raise self.fault(line, f"'{name}' is not later than in the row before", "sort the rows by time")
        return found

    def missing(self, what: str, hint: str) -> ParamError:
        """Return the error of a file without a column that is needed."""
        return ParamError(self._param, f"'{self._path}' has {what}; its columns are {', '.join(self.names)}", hint)


def _name(name: str) -> str:
    plain = re.sub(r"\s*\[(\w+)\]\s*$", r"_\1", name.strip().lstrip("#").strip())
    return plain.lower()
