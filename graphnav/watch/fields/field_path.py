"""Paths to parts of a message: ``pose.x``, ``uv_px[0][3]``, ``stages[-1].name``, ``samples[2:8]``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from graphnav import Place, UserError

Index = int | slice

_STEP = re.compile(r"([A-Za-z_]\w*)((?:\[[^\[\]]*\])*)")
_INDEX = re.compile(r"-?\d{1,9}")
_SLICE = re.compile(r"(-?\d{1,9})?:(-?\d{1,9})?(?::(\d{1,9}))?")


class Missing(Enum):
    """The value of an element beyond the end of an array."""

    ELEMENT = "missing"


MISSING = Missing.ELEMENT


@dataclass(frozen=True)
class Step:
    """One field of a path, with indices or slices for arrays."""

    name: str
    indices: tuple[Index, ...] = ()


@dataclass(frozen=True)
class FieldPath:
    """A path to a part of a message; ``text``: as written."""

    text: str
    steps: tuple[Step, ...]

    def pick(self, values: Mapping[str, Any]) -> Any:
        """Return this part of a message's fields, MISSING if an array is too short."""
        found: Any = values
        for step in self.steps:
            found = found[step.name]
            if step.indices:
                try:
                    found = found[step.indices] if isinstance(found, np.ndarray) else found[step.indices[0]]
                except IndexError:
                    return MISSING
        return found.item() if isinstance(found, np.generic) else found


def path_of(steps: tuple[Step, ...]) -> FieldPath:
    """Return the path of steps without slices, in text form."""
    text = ".".join(step.name + "".join(f"[{index}]" for index in step.indices) for step in steps)
    return FieldPath(text, steps)


def parse_field(text: str) -> FieldPath:
    """Parse a path.

    Raises
    ------
    UserError
        It is not a path.
    """
    steps = []
    for part in text.split("."):
        found = _STEP.fullmatch(part)
        if found is None:
            raise _wrong(text)
        indices = [_index(inside, text) for inside in re.findall(r"\[([^\[\]]*)\]", found[2])]
        steps.append(Step(found[1], tuple(indices)))
    return FieldPath(text, tuple(steps))


def _index(inside: str, text: str) -> Index:
    if _INDEX.fullmatch(inside):
        return int(inside)
    found = _SLICE.fullmatch(inside)
    if found is None or found[3] == "0":
        raise _wrong(text)
    start, stop, step = (None if part is None else int(part) for part in found.groups())
    return slice(start, stop, step)


def _wrong(text: str) -> UserError:
    return UserError.of(f"'{text}' is not a path to a field", "write a.b, a[0], a[0][1] or a[2:8]", Place("--field"))
