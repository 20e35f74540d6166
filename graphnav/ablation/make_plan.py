"""Turn a study into a checked plan, before anything runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from graphnav.ablation.checked_case import Checked, check_cases, stage_classes
from graphnav.ablation.expand import Variant, expand
from graphnav.ablation.figure_text import FigureText
from graphnav.ablation.findings import Findings
from graphnav.ablation.folder_names import folder_names
from graphnav.ablation.plan import Better, Case, Plan
from graphnav.ablation.study import Study
from graphnav.ablation.targets import targets_of
from graphnav.catalog import Catalog
from graphnav.errors import Place, Problem, UserError, did_you_mean
from graphnav.graph import resolved_yaml
from graphnav.runner.summary import versions
from graphnav.stage import Stage


def make_plan(study: Study, catalog: Catalog, command: str, plugins: Sequence[Path] = ()) -> Plan:
    """Return the plan of a study after every graph with every variant was loaded and checked.

    Costs about 10 ms a case, and what its stages take to look at their files. ``command`` and ``plugins`` are written
    down for those who run it again.

    Raises
    ------
    UserError
        Everything that is wrong with the study and its graphs, each said once.
    """
    variants = expand(study)
    problems = list(_problems_of(study, variants))
    if problems:
        raise UserError(dict.fromkeys(problems))
    findings = Findings(study.axes)
    checked = check_cases(study, variants, catalog, findings)
    problems = findings.problems()
    classes = stage_classes(checked)
    figures: dict[str, Better] = {}
    for text in study.figures:
        try:
            figure = FigureText.parse(text)
        except UserError as error:
            problems += [Problem(study.places.get(text), p.what, p.hint) for p in error.problems]
            continue
        if not problems:
            problems += _figure_problems(figure, study.places.get(text), classes)
        figures[figure.text] = _better(figure, classes)
    if problems:
        raise UserError(dict.fromkeys(problems))
    return Plan(
        name=study.name,
        about=study.about,
        command=command,
        graphs=study.graphs,
        axes={axis.name: tuple(choice.label for choice in axis.choices) for axis in study.axes},
        seeds=study.seeds,
        figures=figures,
        cases=tuple(_cases(study, variants, checked)),
        less_is_better=tuple(
            dict.fromkeys(
                f"{name}.{f}" for name, found in classes.items() for cls in found for f in sorted(cls.less_is_better)
            )
        ),
        plugins=tuple(str(path.absolute()) for path in plugins),
        versions=versions(),
    )


def _problems_of(study: Study, variants: tuple[Variant, ...]) -> Iterator[Problem]:
    """Yield what is wrong whatever the graphs say."""
    if not study.graphs:
        yield Problem(None, "the study has no graphs", "name one: graphnav ablate corridor_ccw ...")
    if not study.seeds:
        yield Problem(None, f"the study '{study.name}' has no seeds", "say which worlds: --seeds 0:50")
    for variant in variants:
        said: dict[tuple[str, str], str] = {target: "'set'" for text in study.sets for target in targets_of(text)}
        for axis, choice in variant.choices.items():
            for text, place in zip(choice.sets, choice.places or (choice.place,) * len(choice.sets), strict=True):
                for target in targets_of(text):
                    if said.get(target, axis) != axis:
                        name = ".".join(filter(None, target))
                        yield Problem(place, f"axis '{axis}' sets {name}, as {said[target]} does", "keep one")
                    said[target] = f"axis '{axis}'"


def _figure_problems(
    figure: FigureText, place: Place | None, classes: dict[str, list[type[Stage]]]
) -> Iterator[Problem]:
    scored = {name for name, found in classes.items() if any(cls.summary is not Stage.summary for cls in found)}
    for operand in figure.operands:
        stage = operand.partition(".")[0]
        if stage not in classes:
            hint = did_you_mean(stage, scored) or f"stages with figures are {', '.join(sorted(scored))}"
            yield Problem(place, f"'{operand}': no graph has a stage '{stage}'", hint)
        elif stage not in scored:
            hint = f"stages with figures are {', '.join(sorted(scored))}"
            yield Problem(place, f"'{operand}': stage '{stage}' ({classes[stage][0].__name__}) says no figures", hint)


def _better(figure: FigureText, classes: dict[str, list[type[Stage]]]) -> Better:
    stage, _, name = figure.operands[0].partition(".")
    return "less" if any(name in cls.less_is_better for cls in classes.get(stage, ())) else "more"


def _cases(study: Study, variants: tuple[Variant, ...], checked: Sequence[Checked]) -> Iterator[Case]:
    folders = folder_names(study.graphs), folder_names(variant.name for variant in variants)
    first: dict[object, Checked] = {}
    base: dict[str, Checked] = {}
    for case in checked:
        same = first.setdefault(case.identity, case)
        base.setdefault(case.name, case)
        before = base[case.name].uses
        yield Case(
            graph=case.name,
            variant=case.variant.name,
            labels=case.variant.labels,
            sets=case.sets,
            is_base=case.variant.is_base,
            role=case.role,
            folder=f"runs/{folders[0][case.name]}/{folders[1][same.variant.name]}",
            same_as="" if same is case else same.variant.name,
            uses=case.uses,
            swapped=tuple(stage for stage, use in case.uses.items() if before.get(stage) != use),
            notices=case.notices,
            graph_yaml=resolved_yaml(case.graph),
        )
