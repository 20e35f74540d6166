"""Decode the newest messages of a watch on demand."""

from __future__ import annotations

from contextlib import suppress
from typing import Any, Protocol, TypeVar

import numpy as np

from graphnav import Adapter, Message, PictureContext, State
from graphnav.arrays import Doubles
from graphnav.core.catalog import Catalog
from graphnav.core.codec import DecodeError, codec_of, message_class_of, type_of
from graphnav.core.errors import CatalogError, one_line
from graphnav.core.interrupts import CtrlC
from graphnav.watch.feed import Received

M = TypeVar("M", bound=Message)

_MAX_POINTS = 20_000


class Messages(Protocol):
    """The newest messages of a watched feed."""

    def newest(self, name: str, /) -> Received | None:
        """Return the newest message of a channel."""

    def recent(self, name: str, after_s: float, /) -> list[Received]:
        """Return the stored messages of a channel that arrived after ``after_s``, oldest first."""

    def names_of(self, lcm_class: type, /) -> list[str]:
        """Return the channels that carry a type."""


class Moment:
    """Decodes the newest messages of a watch, and tracks the robot's path while it is used.

    ``with_colour``: whether pictures may use colours.
    """

    with_colour = True

    def __init__(self, watch: Messages, catalog: Catalog) -> None:
        self._watch = watch
        self._readers: dict[type, Adapter] = {}
        with suppress(CatalogError):
            self._readers = {adapter.lcm_class: adapter for adapter in catalog.adapters().readers.values()}
        self._path_name = ""
        self._path: list[tuple[float, float]] = []
        self._path_s = -np.inf
        self._path_us = 0

    def values(self, data: bytes) -> dict[str, Any] | None:
        """Return the fields of a message, None if its type is unknown or it is damaged."""
        lcm_class = type_of(data)
        if lcm_class is None:
            return None
        with suppress(DecodeError):
            return codec_of(lcm_class).decode(data)
        return None

    def message(self, data: bytes) -> Message | None:
        """Return a decoded message, also through an adapter; None if its type has no message class or it is damaged.

        Raises ValueError where an adapter cannot use the fields, else the exceptions of the message class.
        """
        lcm_class, values = type_of(data), self.values(data)
        if lcm_class is None or values is None:
            return None
        wrapper = message_class_of(lcm_class)
        if wrapper is not None:
            return wrapper.from_lcm_fields(values)
        if lcm_class not in self._readers:
            return None
        try:
            return self._readers[lcm_class].from_lcm(values)
        except CtrlC:
            raise
        except BaseException as error:
            raise ValueError(one_line(error)) from error

    def context(self, rows: int, cols: int, *, with_legend: bool) -> PictureContext:
        """Return the context for pictures."""
        return PictureContext(rows, cols, self.find, self.path_m, with_legend, self.with_colour)

    def find(self, kind: type[M], /) -> M | None:
        """Return the newest message of a type, from the first channel of this type."""
        theirs = [lcm_class for lcm_class, adapter in self._readers.items() if issubclass(adapter.message, kind)]
        for lcm_class in (kind.lcm_class, *kind.former_lcm_classes, *theirs):
            for name in self._watch.names_of(lcm_class):
                sample = self._watch.newest(name)
                with suppress(KeyError, TypeError, ValueError):
                    message = None if sample is None else self.message(sample.data)
                    if isinstance(message, kind):
                        return message
        return None

    def path_m(self) -> Doubles:
        """Return the robot's path, float64 (n, 2), x_m and y_m; restarts if its timestamps go back."""
        name = next(iter(self._watch.names_of(State.lcm_class)), None)
        newest = None if name is None else self._watch.newest(name)
        if name is None or newest is None:
            return np.empty((0, 2))
        if name != self._path_name or newest.at_s < self._path_s:
            self._path_name, self._path, self._path_s = name, [], -np.inf
        codec = codec_of(State.lcm_class)
        for sample in self._watch.recent(name, self._path_s):
            self._path_s = sample.at_s
            if not codec.fits(sample.data):
                continue
            fields = codec.decode(sample.data)
            if fields["utime"] < self._path_us:
                self._path = []
            self._path_us = fields["utime"]
            self._path.append((fields["x_m"], fields["y_m"]))
        del self._path[:-_MAX_POINTS]
        return np.array(self._path, np.float64).reshape(-1, 2)
