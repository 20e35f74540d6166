"""A study: its graphs, axes, seeds, metrics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from graphnav.errors import Place


@dataclass(frozen=True)
class Choice:
    """One value of an axis: what tables call it, and the ``--set`` texts that make it (none: the graph as it is)."""

    label: str
    sets: tuple[str, ...]
    places: tuple[Place, ...] = field(default=(), compare=False)
    """The place of each of ``sets``."""
    place: Place | None = field(default=None, compare=False)

    @property
    def placed_sets(self) -> tuple[tuple[str, Place | None], ...]:
        """Its ``--set`` texts, each with its place."""
        return tuple(zip(self.sets, self.places or (self.place,) * len(self.sets), strict=True))


@dataclass(frozen=True)
class Axis:
    """One thing that varies; the first choice is the base's."""

    name: str
    choices: tuple[Choice, ...]
    place: Place | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Study:
    """A study as its file or the command line specifies it."""

    name: str
    about: str
    """The question that it answers."""
    graphs: tuple[str, ...]
    axes: tuple[Axis, ...]
    seeds: tuple[int, ...]
    sets: tuple[str, ...] = ()
    """Applied to every run, before those of the axes."""
    metrics: tuple[str, ...] = ()
    """Columns of the table, ``stage.metric``, the one that decides first; empty for all metrics."""
    within: tuple[str, ...] = ()
    """Axes that are conditions: variants are compared with the base within each combination of their choices."""
    one_at_a_time: bool = False
    """Whether each variant differs from the base in one axis; else the axes cross."""
    folder: Path | None = field(default=None, compare=False)
    """That of its file, beside which its paths are looked for first; None for a study of the command line."""
    places: Mapping[str, Place] = field(default_factory=dict, compare=False)
    """The place of each of ``graphs``, ``sets``, ``metrics`` and ``within``."""
