"""The study that a command line says: of graphs, or a study file with something else."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from graphnav.ablation.study.find_study import classify
from graphnav.ablation.study.override_targets import targets_of
from graphnav.ablation.study.seeds import parse_seeds
from graphnav.ablation.study.study import Study
from graphnav.ablation.study.study_file import load_study
from graphnav.ablation.study.vary_option import varied
from graphnav.errors import Place, Problem, UserError
from graphnav.graph import find_graph

_VARY = "write --vary plane=plane.ica,plane.affine, or name a study"


def study_of_command(
    names: Sequence[str],
    *,
    varies: Sequence[str] = (),
    sets: Sequence[str] = (),
    figures: Sequence[str] = (),
    within: Sequence[str] = (),
    seeds: str | None = None,
    one_at_a_time: bool = False,
) -> Study:
    """Return the study that ``graphnav ablate NAMES`` with its options means.

    ``names``: one study, or graphs, each a file or a name. ``--vary`` replaces an axis of the study of that name or
    adds one, ``--vary AXIS+=VALUE`` adds a choice (see `varied`); ``--set`` comes before what the study sets of the
    same; ``--figures`` and ``--within`` (texts with commas between) and ``--seeds`` replace the study's.

    Raises
    ------
    UserError
        Everything that is wrong with the names and the options.
    """
    base = _named(names)
    problems: list[Problem] = []
    axes = varied(base.axes, varies, problems)
    if not axes and not problems:
        problems.append(Problem(None, "the study varies nothing", _VARY))
    found = base.seeds
    if seeds is not None:
        try:
            found = parse_seeds(seeds, Place("--seeds"))
        except UserError as error:
            problems += error.problems
    given = _split(figures)
    if "" in given:
        problems.append(Problem(Place("--figures"), "a figure is empty", "write --figures drive.success,drive.spl"))
    conditions = _split(within)
    if "" in conditions:
        problems.append(Problem(Place("--within"), "an axis is empty", "write --within control.max_speed_mps"))
    if problems:
        raise UserError(problems)
    new = {target for text in sets for target in targets_of(text)}
    kept = [text for text in base.sets if not new.issuperset(targets_of(text))]
    places = {text: Place(f"--set {text}") for text in sets} | {text: Place("--figures") for text in given}
    places |= {text: Place("--within") for text in conditions}
    do = "does" if len(axes) == 1 else "do"
    about = base.about or f"What {do} {_listed(axis.name for axis in axes)} change on {_listed(base.graphs)}?"
    return replace(
        base,
        about=about,
        axes=axes,
        seeds=found,
        sets=(*kept, *sets),
        figures=tuple(given) or base.figures,
        within=tuple(dict.fromkeys(conditions)) or base.within,
        one_at_a_time=one_at_a_time or base.one_at_a_time,
        places={**base.places, **places},
    )


def _split(texts: Sequence[str]) -> list[str]:
    return [part.strip() for text in texts for part in text.split(",")]


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


def _listed(names: Iterable[str]) -> str:
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last
