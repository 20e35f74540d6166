"""The arguments of `graphnav.ablate`, checked: an error names the argument, what it is and what to write."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Mapping, Sequence

from graphnav.core.api.arguments import path_of, wrong_type, yaml_value
from graphnav.core.errors import Place, UserError
from graphnav.core.graph import Graph
from graphnav.studies.ablation.study import Vary, vary_of
from graphnav.studies.api.study_run import ExecutionOptions


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
    return tuple(str(path_of(name, "study", "corridor_ccw")) for name in found)


def varies_of(vary: object) -> tuple[Vary, ...]:
    """Return the changes of axes in a mapping of axes to their values.

    Raises
    ------
    UserError
        It is not a mapping of lists, or a graph cannot hold a value.
    """
    hint = 'write vary={"plane": ["plane.ica", "plane.affine"]}'
    if vary is None:
        return ()
    if not isinstance(vary, Mapping):
        raise wrong_type("vary", vary, "a mapping", hint)
    found = []
    for axis, values in vary.items():
        if not isinstance(axis, str) or not axis or "=" in axis:
            raise UserError.of(f"vary: {axis!r} is not a stage, a parameter or a wire", hint)
        name = f"vary[{axis!r}]"
        if isinstance(values, set | frozenset):
            raise wrong_type(name, values, "a list of values, the base's first (a set has no order)", hint)
        if isinstance(values, str | Mapping) or not isinstance(values, Iterable):
            raise wrong_type(name, values, "a list of values", hint)
        found.append(vary_of(axis, [yaml_value(value, name) for value in values], Place(name)))
    return tuple(found)


def seeds_of(seeds: object) -> Sequence[int] | None:
    """Return seeds; None for None.

    Raises
    ------
    UserError
        It is not a list of integers.
    """
    hint = "write seeds=range(1000, 1010), or [1, 5, 7]"
    if seeds is None or (isinstance(seeds, range) and seeds.step == 1 and 0 <= seeds.start < seeds.stop):
        return seeds
    if isinstance(seeds, str | bytes | Mapping) or not isinstance(seeds, Iterable):
        raise wrong_type("seeds", seeds, "a range or a list of integers", hint)
    found = list(seeds)
    for seed in found:
        if isinstance(seed, bool) or not hasattr(seed, "__index__"):
            raise wrong_type("seeds", seed, "a range or a list of integers", hint)
        if operator.index(seed) < 0:
            raise UserError.of(f"seeds: a seed must be 0 or more, not {seed}", hint)
    if not found:
        raise UserError.of("seeds is empty", hint)
    return [operator.index(seed) for seed in found]


def reference_of(reference: object) -> str | None:
    """Return the name of a variant, None for None.

    Raises
    ------
    UserError
        It is not a string.
    """
    if reference is not None and not isinstance(reference, str):
        raise wrong_type("reference", reference, "the name of a variant", 'write reference="steer.oracle"')
    return reference


def worlds_of(worlds: object) -> Mapping[str, int]:
    """Return the number of worlds of graphs.

    Raises
    ------
    UserError
        It is not a mapping of graphs to positive integers.
    """
    hint = 'write worlds={"suite/laps": 10}'
    if worlds is None:
        return {}
    if not isinstance(worlds, Mapping):
        raise wrong_type("worlds", worlds, "a mapping of graphs to numbers", hint)
    for graph, number in worlds.items():
        if not isinstance(graph, str):
            raise wrong_type("worlds", graph, "a mapping of graphs to numbers", hint)
        _checked_count(f"worlds[{graph!r}]", number, 1)
    return dict(worlds)


def execution_of(
    jobs: object, cluster: object, gallery: object, keep_logs: object, fail_fast: object
) -> ExecutionOptions:
    """Return how runs are made.

    Raises
    ------
    UserError
        An argument has a wrong type.
    """
    if cluster is not None and not isinstance(cluster, str):
        raise wrong_type("cluster", cluster, "a string or None", 'write cluster="tcp://host:8786"')
    at_once, each = _count("jobs", jobs, 1), _count("gallery", gallery, 0)
    return ExecutionOptions(at_once, cluster, each or 0, keep_logs=bool(keep_logs), fail_fast=bool(fail_fast))


def _count(name: str, value: object, minimum: int) -> int | None:
    return None if value is None else _checked_count(name, value, minimum)


def _checked_count(name: str, value: object, minimum: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < minimum:
        raise wrong_type(name, value, f"an integer of at least {minimum}", f"write {name}=2")
    return value
