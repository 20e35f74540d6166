"""From the arguments of `graphnav.ablate`, or the options of the command, to a checked plan."""

from __future__ import annotations

import operator
import shlex
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from graphnav.ablation.plan import Plan, make_plan, with_versions
from graphnav.ablation.study import Study
from graphnav.api.arguments import path_of, value_text, wrong_type
from graphnav.catalog import Catalog
from graphnav.errors import UserError
from graphnav.graph import Graph


def checked_plan(study: Study, catalog: Catalog, command: str, plugins: Sequence[Path]) -> Plan:
    """Return the plan of a study with the versions that its runs depend on.

    Raises
    ------
    UserError
        Everything that is wrong with it and its graphs.
    """
    return with_versions(make_plan(study, catalog, command, plugins))


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


def vary_texts(vary: Mapping[str, Sequence[object]] | None) -> list[str]:
    """Return what ``--vary`` takes for a mapping of axes to their values.

    Raises
    ------
    UserError
        It is not a mapping of lists, or it holds what a graph cannot.
    """
    hint = 'write vary={"plane": ["plane.ica", "plane.affine"]}'
    if vary is None:
        return []
    if not isinstance(vary, Mapping):
        raise wrong_type("vary", vary, "a mapping", hint)
    texts = []
    for axis, values in vary.items():
        if not isinstance(axis, str) or not axis or "=" in axis:
            raise UserError.of(f"vary: {axis!r} is not a stage, a parameter or a wire", hint)
        if isinstance(values, str | Mapping) or not isinstance(values, Iterable):
            raise wrong_type(f"vary[{axis!r}]", values, "a list of values", hint)
        texts.append(f"{axis}={','.join(value_text(value, f'vary[{axis!r}]') for value in values)}")
    return texts


def seeds_text(seeds: object) -> str | None:
    """Return what ``--seeds`` takes; None for None.

    Raises
    ------
    UserError
        It is not a list of integers.
    """
    hint = "write seeds=range(1000, 1010), or [1, 5, 7]"
    if seeds is None:
        return None
    if isinstance(seeds, str | bytes | Mapping) or not isinstance(seeds, Iterable):
        raise wrong_type("seeds", seeds, "a range or a list of integers", hint)
    if isinstance(seeds, range) and seeds.step == 1 and 0 <= seeds.start < seeds.stop:
        return f"{seeds.start}:{seeds.stop}"
    found = list(seeds)
    for seed in found:
        if isinstance(seed, bool) or not hasattr(seed, "__index__"):
            raise wrong_type("seeds", seed, "a range or a list of integers", hint)
        if operator.index(seed) < 0:
            raise UserError.of(f"seeds: a seed must be 0 or more, not {seed}", hint)
    if not found:
        raise UserError.of("seeds is empty", hint)
    return f"[{', '.join(str(operator.index(seed)) for seed in found)}]"


def words_of(
    names: Sequence[str],
    *,
    varies: Sequence[str],
    sets: Sequence[str],
    seeds: str | None,
    metrics: Sequence[str],
    within: Sequence[str],
    one_at_a_time: bool,
    plugins: Sequence[Path],
) -> str:
    """Return the command line that runs the same study."""
    options = (("--vary", varies), ("--set", sets), ("--metrics", metrics), ("--within", within), ("--plugin", plugins))
    words = ["graphnav", "ablate", *names]
    for option, values in options:
        words += [word for value in values for word in (option, str(value))]
    words += ["--seeds", seeds] if seeds is not None else []
    return shlex.join([*words, *(["--one-at-a-time"] if one_at_a_time else [])])
