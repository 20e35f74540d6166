"""The arguments of `graphnav.ablate`, checked: an error names the argument, what it is and what to write."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Mapping, Sequence

from graphnav import Graph, Place, UserError
from graphnav.core.api import Argument
from graphnav.core.parameters import COUNT
from graphnav.studies.ablation.study import Vary, vary_of
from graphnav.studies.api.study_run import ExecutionOptions
from graphnav.studies.parameters import CLUSTER, GALLERY, JOBS, SEEDS, STUDY, VARY, WORLDS

_WORLDS_OF_GRAPH = WORLDS.but(type=COUNT, example="2")


def names_of(study: object) -> tuple[str, ...]:
    """Return what is named: one study, or graphs.

    Raises
    ------
    UserError
        It is neither a name nor a list of names.
    """
    hint = 'write "corridor_ccw", or ["corridor_ccw", "pillars"]'
    found = study if isinstance(study, list | tuple) else (study,)
    if any(isinstance(name, Graph) for name in found):
        raise UserError.of(
            "study names graphs by their files, and this is a loaded graph", f"{hint}; give set to ablate"
        )
    if not found:
        raise UserError.of("study names no graph", hint)
    return tuple(str(Argument(name, STUDY).path()) for name in found)


def varies_of(vary: object) -> tuple[Vary, ...]:
    """Return the changes of axes in a mapping of axes to their values.

    Raises
    ------
    UserError
        It is not a mapping of lists, or a graph cannot hold a value.
    """
    hint = VARY.hint
    if vary is None:
        return ()
    if not isinstance(vary, Mapping):
        raise Argument(vary, VARY).error("a mapping")
    found = []
    for axis, values in vary.items():
        if not isinstance(axis, str) or not axis or "=" in axis:
            raise UserError.of(f"vary: {axis!r} is not a stage, a parameter or a wire", hint)
        given = Argument(values, VARY, f"[{axis!r}]")
        if isinstance(values, set | frozenset):
            raise given.error("a list of values, the base's first (a set has no order)")
        if isinstance(values, str | Mapping) or not isinstance(values, Iterable):
            raise given.error("a list of values")
        found.append(vary_of(axis, [Argument(value, VARY, given.place).yaml() for value in values], Place(given.name)))
    return tuple(found)


def seeds_of(seeds: object) -> Sequence[int] | None:
    """Return seeds; None for None.

    Raises
    ------
    UserError
        It is not a list of integers.
    """
    hint = SEEDS.hint
    if seeds is None or (isinstance(seeds, range) and seeds.step == 1 and 0 <= seeds.start < seeds.stop):
        return seeds
    if isinstance(seeds, str | bytes | Mapping) or not isinstance(seeds, Iterable):
        raise Argument(seeds, SEEDS).error("a range or a list of integers")
    found = list(seeds)
    for seed in found:
        if isinstance(seed, bool) or not hasattr(seed, "__index__"):
            raise Argument(seed, SEEDS).error("a range or a list of integers")
        if operator.index(seed) < 0:
            raise UserError.of(f"seeds: a seed must be 0 or more, not {seed}", hint)
    if not found:
        raise UserError.of("seeds is empty", hint)
    return [operator.index(seed) for seed in found]


def worlds_of(worlds: object) -> Mapping[str, int]:
    """Return the number of worlds of graphs.

    Raises
    ------
    UserError
        It is not a mapping of graphs to positive integers.
    """
    if worlds is None:
        return {}
    if not isinstance(worlds, Mapping):
        raise Argument(worlds, WORLDS).error("a mapping of graphs to numbers")
    for graph, number in worlds.items():
        if not isinstance(graph, str):
            raise Argument(graph, WORLDS).error("a mapping of graphs to numbers")
        Argument(number, _WORLDS_OF_GRAPH, f"[{graph!r}]").check_integer()
    return dict(worlds)


def execution_of(
    jobs: int | None, cluster: str | None, gallery: int, keep_logs: object, fail_fast: object
) -> ExecutionOptions:
    """Return how runs are made.

    Raises
    ------
    UserError
        An argument has a wrong type.
    """
    Argument(cluster, CLUSTER).check_text()
    if jobs is not None:
        Argument(jobs, JOBS).check_integer()
    Argument(gallery, GALLERY).check_integer()
    return ExecutionOptions(jobs, cluster, gallery, keep_logs=bool(keep_logs), fail_fast=bool(fail_fast))
