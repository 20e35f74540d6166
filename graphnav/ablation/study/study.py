"""A study: its graphs, axes, seeds, metrics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from graphnav.ablation.study.decomposition import Decomposition
from graphnav.errors import Place
from graphnav.graph import Override


@dataclass(frozen=True)
class Choice:
    """One value of an axis: its label in tables, and the overrides that make it (none: the graph as it is)."""

    label: str
    overrides: tuple[Override, ...]
    place: Place | None = field(default=None, compare=False)


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
    overrides: tuple[Override, ...] = ()
    """Applied to every run, before those of the axes."""
    metrics: tuple[str, ...] = ()
    """Columns of the table, ``stage.metric``, the one that decides first; empty for all metrics."""
    within: tuple[str, ...] = ()
    """Axes that are conditions: variants are compared with the base within each combination of their choices."""
    one_at_a_time: bool = False
    """Whether each variant differs from the base in one axis; else the axes cross."""
    reference: str = ""
    """The variant whose runs metrics may be relative to; empty for none."""
    worlds: Mapping[str, int] = field(default_factory=dict)
    """By graph: how many of the seeds, the first ones, are its worlds; all of them where it is not named."""
    decomposition: Decomposition | None = None
    """What it decomposes, for the report; None for other studies."""
    places: dict[str, Place] = field(default_factory=dict, compare=False)
    """The place of each of ``graphs``, ``metrics`` and ``within``, and of the reference."""
