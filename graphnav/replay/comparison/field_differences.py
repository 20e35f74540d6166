"""Compare two messages of one type field by field."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

SEQ = "seq"
"""The sequence number, which does not depend on the content of a message."""


@dataclass(frozen=True)
class Tolerance:
    """The allowed difference of numbers: ``|recorded - replayed| <= max_abs + max_rel * |recorded|``."""

    max_abs: float = 0.0
    max_rel: float = 0.0


class Difference(NamedTuple):
    """A field that differs: the first position, the two values there, and the maximum difference of numbers.

    ``where``: the index of the element in an array, empty for a scalar. ``gap``: None unless both values are numbers,
    infinity if one of them is not finite.
    """

    where: tuple[int, ...]
    recorded: Any
    replayed: Any
    gap: float | None


def field_differences(
    recorded: Mapping[str, Any], replayed: Mapping[str, Any], tolerance: Tolerance
) -> dict[str, Difference]:
    """Return the differences of two messages by field; nested structs as ``struct.field``."""
    found: dict[str, Difference] = {}
    for name, value in recorded.items():
        if name != SEQ:
            for path, difference in _compared(name, (), value, replayed[name], tolerance):
                found[path] = _merged(found[path], difference) if path in found else difference
    return found


def _merged(first: Difference, other: Difference) -> Difference:
    gaps = [gap for gap in (first.gap, other.gap) if gap is not None]
    return first._replace(gap=max(gaps, default=None))


def _compared(
    path: str, index: tuple[int, ...], recorded: Any, replayed: Any, tolerance: Tolerance
) -> Iterator[tuple[str, Difference]]:
    if isinstance(recorded, Mapping):
        for name, value in recorded.items():
            yield from _compared(f"{path}.{name}", index, value, replayed[name], tolerance)
    elif isinstance(recorded, np.ndarray) and recorded.dtype != object:
        difference = _of_arrays(recorded, replayed, tolerance)
        if difference is not None:
            yield path, difference._replace(where=(*index, *difference.where))
    elif isinstance(recorded, np.ndarray | tuple | list):
        yield from _compared_sequences(path, index, list(recorded), list(replayed), tolerance)
    elif isinstance(recorded, int | float) and isinstance(replayed, int | float):
        gap = _gap(float(recorded), float(replayed))
        if recorded != replayed and not gap <= _allowed(float(recorded), tolerance):
            yield path, Difference(index, recorded, replayed, gap)
    elif recorded != replayed:
        yield path, Difference(index, recorded, replayed, None)


def _compared_sequences(
    path: str, index: tuple[int, ...], recorded: Sequence[Any], replayed: Sequence[Any], tolerance: Tolerance
) -> Iterator[tuple[str, Difference]]:
    if len(recorded) != len(replayed):
        yield path, Difference(index, f"{len(recorded)} entries", f"{len(replayed)} entries", None)
        return
    for place, (one, other) in enumerate(zip(recorded, replayed, strict=True)):
        yield from _compared(path, (*index, place), one, other, tolerance)


def _of_arrays(recorded: npt.NDArray[Any], replayed: npt.NDArray[Any], tolerance: Tolerance) -> Difference | None:
    if recorded.shape != replayed.shape:
        return Difference((), f"shape {recorded.shape}", f"shape {replayed.shape}", None)
    with np.errstate(all="ignore"):  # a damaged message may hold any value
        wrong = recorded != replayed
        if not wrong.any():
            return None
        old, new = recorded[wrong].astype(np.float64), replayed[wrong].astype(np.float64)
        gaps = np.abs(old - new)
        apart = ~(gaps <= tolerance.max_abs + tolerance.max_rel * np.abs(old)) & ~(np.isnan(old) & np.isnan(new))
    if not apart.any():
        return None
    places = np.argwhere(wrong)[apart]
    first = tuple(int(number) for number in places[0])
    gap = float(np.max(np.where(np.isnan(gaps[apart]), math.inf, gaps[apart])))
    return Difference(first, recorded[first].item(), replayed[first].item(), gap)


def _gap(recorded: float, replayed: float) -> float:
    if math.isnan(recorded) and math.isnan(replayed):
        return 0.0
    gap = abs(recorded - replayed)
    return math.inf if math.isnan(gap) else gap


def _allowed(recorded: float, tolerance: Tolerance) -> float:
    allowed = tolerance.max_abs + tolerance.max_rel * abs(recorded)
    return 0.0 if math.isnan(allowed) else allowed
