"""Build the study of a command line: graphs with ``--vary``, or a study file with changes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from graphnav import Place, Problem, UserError
from graphnav.core.graph import Override, find_graph
from graphnav.studies.ablation.study.find_study import classify
from graphnav.studies.ablation.study.study import Axis, Study
from graphnav.studies.ablation.study.study_file import load_study
from graphnav.studies.ablation.study.vary import Vary, varied
from graphnav.studies.ablation.study.worlds import checked_seeds, parse_seeds, replaced_worlds

_VARY = "write --vary plane=plane.ica,plane.affine, or name a study"
_METRICS, _WITHIN = "write --metrics drive.success,drive.spl", "write --within control.max_speed_mps"


def study_of_command(
    names: Sequence[str],
    *,
    varies: Sequence[Vary] = (),
    overrides: Sequence[Override] = (),
    metrics: Sequence[str] = (),
    within: Sequence[str] = (),
    seeds: str | Sequence[int] | None = None,
    one_at_a_time: bool = False,
    reference: str | None = None,
    worlds: Mapping[str, int] = MappingProxyType({}),
    may_vary_nothing: bool = False,
    problems: Sequence[Problem] = (),
) -> Study:
    """Return the study that ``graphnav ablate NAMES`` with its options means.

    ``names``: one study, or graphs, each a file or a name. ``varies`` change the axes of the study (see `varied`);
    ``overrides`` take the place of the study's with the same targets; ``metrics`` and ``within`` (strings with commas
    between), ``seeds``, ``reference`` and ``worlds`` replace the study's. ``may_vary_nothing``: axes are added to it
    later. ``problems``: what is wrong with options that were read before.

    Raises
    ------
    UserError
        Everything that is wrong with the names and the options.
    """
    base = _named(names)
    problems = list(problems)
    axes = varied(base.axes, varies, problems)
    if not axes and not problems and not may_vary_nothing:
        problems.append(Problem(None, "the study varies nothing", _VARY))
    found = base.seeds if seeds is None else _seeds(seeds, problems)
    limits = replaced_worlds(base.worlds, worlds, base.graphs, problems)
    columns = _split(metrics, Problem(Place("--metrics"), "a metric is empty", _METRICS), problems)
    conditions = _split(within, Problem(Place("--within"), "an axis is empty", _WITHIN), problems)
    if problems:
        raise UserError(problems)
    return replace(
        base,
        about=base.about or (_question(axes, base.graphs) if axes else ""),
        axes=axes,
        seeds=found,
        overrides=(*_not_replaced(base.overrides, overrides), *overrides),
        metrics=tuple(columns) or base.metrics,
        within=tuple(dict.fromkeys(conditions)) or base.within,
        one_at_a_time=one_at_a_time or base.one_at_a_time,
        reference=base.reference if reference is None else reference,
        worlds=limits,
        places=base.places | _placed({"--metrics": columns, "--within": conditions, "--reference": [reference or ""]}),
    )


def _placed(words: Mapping[str, Iterable[str]]) -> dict[str, Place]:
    """Return the option of each word, by the words of each option; what is empty has none."""
    return {word: Place(option) for option, of in words.items() for word in of if word}


def _seeds(seeds: str | Sequence[int], problems: list[Problem]) -> tuple[int, ...]:
    place = Place("--seeds")
    try:
        return parse_seeds(seeds, place) if isinstance(seeds, str) else checked_seeds(seeds, place)
    except UserError as error:
        problems += error.problems
        return ()


def _split(texts: Sequence[str], if_empty: Problem, problems: list[Problem]) -> list[str]:
    """Return the words between commas; ``if_empty`` is added to ``problems`` where one is missing."""
    words = [part.strip() for text in texts for part in text.split(",")]
    problems += [if_empty] * ("" in words)
    return words


def _not_replaced(old: Sequence[Override], new: Sequence[Override]) -> list[Override]:
    """Return the overrides of ``old`` without those all of whose targets are set by ``new``."""
    targets = {target for override in new for target in override.target.each}
    return [override for override in old if not targets.issuperset(override.target.each)]


def _question(axes: Sequence[Axis], graphs: Sequence[str]) -> str:
    do = "does" if len(axes) == 1 else "do"
    return f"What {do} {listed(axis.name for axis in axes)} change on {listed(graphs)}?"


def _named(names: Sequence[str]) -> Study:
    """Return the study of a name, or one of graphs that varies nothing yet."""
    kinds = _kinds(names)
    if "study" in kinds:
        if len(names) > 1:
            study = names[kinds.index("study")]
            raise UserError.of("this is a study, which names its own graphs", "give it alone", Place(study))
        return load_study(names[0])
    files: dict[Path, str] = {}
    for name in names:
        file = find_graph(name).resolve()
        if file in files:
            raise UserError.of(f"this is the same graph as '{files[file]}'", "keep one", Place(name))
        files[file] = name
    return Study(
        name="_".join(file.stem for file in files)[:60],
        about="",
        graphs=tuple(names),
        axes=(),
        seeds=(),
        places={name: Place(name) for name in names},
    )


def _kinds(names: Sequence[str]) -> list[str]:
    kinds: list[str] = []
    problems: list[Problem] = []
    for name in names:
        try:
            kinds.append(classify(name))
        except UserError as error:
            problems += error.problems
    if problems:
        raise UserError(problems)
    return kinds


def listed(names: Iterable[str]) -> str:
    """Return ``a``, ``a and b`` or ``a, b and c``."""
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last
