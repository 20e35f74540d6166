"""The base of all messages: frozen dataclasses that name their LCM type."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, Self, dataclass_transform

import numpy as np
import numpy.typing as npt

from graphnav.core.errors import DeclarationError


def snake_case(name: str) -> str:
    """Return ``name`` in the style of stages and ports: ``PlanarModel`` becomes ``planar_model``."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).lower()


ZERO_MEANS = {"step_px": 1}
"""Fields that other programs leave at 0, as in a zeroed C struct, and the value that 0 is read as."""


class FieldError(ValueError):
    """A field of a received message has a value that cannot be used.

    ``allowed`` completes "expected ...", as in "rows is 0, expected 1 or more".
    """

    def __init__(self, field: str, value: object, allowed: str) -> None:
        self.field, self.value, self.allowed = field, value, allowed
        super().__init__(f"{field} is {value}, expected {allowed}")


def may_be_infinite() -> Any:
    """Return a dataclass field whose floats need not be finite."""
    return field(metadata={"finite": False})


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field, may_be_infinite))
class Message:
    """A value on a channel.

    A subclass is a frozen dataclass of numpy arrays and scalars whose names are fields of its LCM type::

        class Flow(Message, lcm=graphnav_lcm.flow_t): ...

    The LCM type also has ``utime`` and ``seq``, which the runner sets, and the array sizes, which the codec derives.
    Received arrays are read-only: copy before writing.
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]
    lcm_class: ClassVar[type]
    former_lcm_classes: ClassVar[tuple[type, ...]] = ()
    """LCM types of this message in older logs, which are read as this message."""
    grid: ClassVar[tuple[str, ...]] = ()
    many_writers: ClassVar[bool] = False
    """Whether several programs may write a channel of this type: then timestamps and sequence numbers are not compared,
    and ages count from the arrival."""
    is_truth: ClassVar[bool] = False
    """Whether it is true data, which no sensor of a robot gives: only stages whose role is score or oracle may read it.
    A message class of another package that carries such data sets it, too."""
    n_classes: ClassVar[int] = 0
    """The number of message classes declared so far, by which caches notice new ones."""
    is_plain: ClassVar[bool]
    """Whether the constructor only stores the fields, so that a decoder need not call it."""
    _names: ClassVar[tuple[str, ...]]
    _floats: ClassVar[tuple[str, ...]]

    def __init_subclass__(
        cls, lcm: type | None = None, grid: tuple[str, ...] = (), former: tuple[type, ...] = (), **kwargs: Any
    ) -> None:
        """Make ``cls`` a frozen dataclass.

        ``grid`` names the fields whose first axes are rows and columns; ``former``: LCM types that it had in older
        logs, with the fields of ``lcm`` and more.
        """
        super().__init_subclass__(**kwargs)
        is_made_by_storing = not {"__init__", "__slots__"} & vars(cls).keys() and not hasattr(cls, "__post_init__")
        dataclass(frozen=True, eq=False)(cls)
        if lcm is None and not hasattr(cls, "lcm_class"):
            raise DeclarationError(
                f"message {cls.__name__} does not name its LCM type: write class {cls.__name__}(Message, lcm=...)"
            )
        if lcm is not None:
            cls.lcm_class = lcm
            cls.former_lcm_classes = former
        cls.grid = grid or cls.grid
        cls._names = tuple(f.name for f in fields(cls))
        cls.is_plain = is_made_by_storing and cls.__new__ is object.__new__ and all(f.init for f in fields(cls))
        cls._floats = tuple(f.name for f in fields(cls) if f.metadata.get("finite", True))
        Message.n_classes += 1

    def lcm_fields(self) -> Mapping[str, Any]:
        """Return the fields of the LCM type, except ``utime``, ``seq`` and array sizes."""
        return self.__dict__

    @classmethod
    def from_lcm_fields(cls, values: Mapping[str, Any]) -> Self:
        """Return the message with the LCM fields ``values`` (all of them); a ``step_px`` of 0 is read as 1.

        Raises
        ------
        FieldError
            A field has a value that no message of this class can hold.
        """
        return cls(
            **{name: values[name] or ZERO_MEANS[name] if name in ZERO_MEANS else values[name] for name in cls._names}
        )

    def thin(self, step: int) -> Self:
        """Return the message with every ``step``-th row and column of its grids, with ``step_px`` adjusted."""
        grids = {name: getattr(self, name)[::step, ::step] for name in self.grid}
        return replace(self, step_px=getattr(self, "step_px") * step, **grids)  # noqa: B009

    def twin(self) -> Self:
        """Return another message with the same values; arrays, which are read-only when received, are shared."""
        if not self.is_plain:
            return copy(self)
        twin = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        return twin

    def not_finite(self) -> str | None:
        """Return the name of the first field with a NaN or infinity that is not allowed, None without one."""
        for name in self._floats:
            value = getattr(self, name)
            if isinstance(value, float):
                if not math.isfinite(value):
                    return name
            elif isinstance(value, np.ndarray) and value.dtype.kind == "f" and not _is_finite(value):
                return name
        return None


def _is_finite(array: npt.NDArray[Any]) -> bool:
    """Whether all elements are finite; checks the sum of squares first, which is cheap unless it overflows."""
    flat = array.ravel("K")
    return math.isfinite(np.vdot(flat, flat)) or bool(np.isfinite(array).all())
