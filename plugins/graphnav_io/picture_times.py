"""The times of recorded pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from graphnav import ParamError
from graphnav.arrays import Longs
from graphnav_io.csv_file import MAX_US, CsvFile

FILES = ("file", "filename", "name", "image", "picture")
"""Names of the column of picture files."""
MIN_PERIOD_US = 500
"""Names that are closer are frame numbers, not times in microseconds."""
WRITE = "write a csv with the columns file and time (time_us, time_s, ...), and give it as 'times'"


class TimedPictures(NamedTuple):
    """Pictures in the order of their times, and the times in microseconds."""

    files: list[Path]
    utimes: Longs


def picture_times(files: Sequence[Path], times: Path | None) -> TimedPictures:
    """Return pictures with their times: by the rows of the csv ``times``, else by names that are microseconds.

    Raises
    ------
    ParamError
        The csv cannot be used, names a picture that does not exist, or names of pictures are not times.
    """
    return _named_times(files) if times is None else _listed_times(files, times)


def row_times(times: Path) -> Longs:
    """Return the times in the rows of a csv, of the frames of a video in their order.

    Raises
    ------
    ParamError
        The csv cannot be used.
    """
    table = CsvFile("times", times)
    return table.utimes(_time_column(table))


def _named_times(files: Sequence[Path]) -> TimedPictures:
    for file in files:
        if not (file.stem.isascii() and file.stem.isdecimal() and float(file.stem) <= MAX_US):
            raise ParamError("times", f"'{file}' is not named by its time in microseconds", WRITE)
    ordered = sorted(files, key=lambda file: int(file.stem))
    utimes = np.array([int(file.stem) for file in ordered], np.int64)
    if len(utimes) > 1 and np.diff(utimes).min() < MIN_PERIOD_US:
        k = int(np.argmin(np.diff(utimes)))
        what = f"'{ordered[k]}' and '{ordered[k + 1].name}' are {utimes[k + 1] - utimes[k]} us apart by their names"
        raise ParamError("times", f"{what}, which are not times in microseconds", WRITE)
    return TimedPictures(ordered, utimes)


def _listed_times(files: Sequence[Path], times: Path) -> TimedPictures:
    table = CsvFile("times", times)
    utimes = table.utimes(_time_column(table))
    column = table.find(FILES)
    if column is None:
        raise table.missing("no column of files", WRITE)
    known = {file.name: file for file in files}
    listed = [Path(word).name for word in table.words(column)]
    missing = [name for name in listed if name not in known]
    if missing:
        what = f"'{times}' lists {len(missing)} pictures that 'path' does not hold, the first is '{missing[0]}'"
        raise ParamError("times", what, "remove its rows, or correct 'path'")
    return TimedPictures([known[name] for name in listed], utimes)


def _time_column(table: CsvFile) -> str:
    column = table.time_column()
    if column is None:
        raise table.missing("no column of times", WRITE)
    return column
