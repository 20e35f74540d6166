"""Turn a study into a checked plan, before anything runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from graphnav.ablation.plan.case_problems import CaseProblems
from graphnav.ablation.plan.checked_cases import CheckedCase, check_cases, stage_classes
from graphnav.ablation.plan.folder_names import folder_names
from graphnav.ablation.plan.metric_checks import checked_metrics, declared_metrics
from graphnav.ablation.plan.plan import RUNS, Case, Plan
from graphnav.ablation.plan.study_problems import study_problems
from graphnav.ablation.plan.variants import Variant, expand
from graphnav.ablation.study import Study, settings_of
from graphnav.catalog import Catalog
from graphnav.errors import UserError
from graphnav.graph import resolved_yaml
from graphnav.runner.recording.summary import versions


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
    if problems := list(study_problems(study, variants)):
        raise UserError(problems)
    found = CaseProblems(study.axes)
    checked = check_cases(study, variants, catalog, found)
    if problems := found.problems():
        raise UserError(dict.fromkeys(problems))
    classes = stage_classes(checked)
    metrics = checked_metrics(study, classes, problems)
    if problems:
        raise UserError(dict.fromkeys(problems))
    cases = tuple(_cases(study, variants, checked))
    return Plan(
        name=study.name,
        about=study.about,
        command=command,
        graphs=tuple(dict.fromkeys(case.graph for case in cases)),
        axes={axis.name: tuple(choice.label for choice in axis.choices) for axis in study.axes},
        seeds=study.seeds,
        metrics=metrics,
        cases=cases,
        within=study.within,
        declared=declared_metrics(classes),
        plugins=_plugins(plugins, checked),
        versions=versions(),
    )


def _plugins(given: Sequence[Path], checked: Sequence[CheckedCase]) -> tuple[str, ...]:
    """Return the plugin files that are given and those that the graphs name, each once."""
    named = (path for case in checked for path in case.graph.plugins)
    return tuple(dict.fromkeys(str(path) for path in (*(path.resolve() for path in given), *named)))


def _cases(study: Study, variants: tuple[Variant, ...], checked: Sequence[CheckedCase]) -> Iterator[Case]:
    of_graph = folder_names(study.graphs, lambda name: Path(name).stem)
    of_variant = folder_names(variant.name for variant in variants)
    first: dict[object, CheckedCase] = {}
    base: dict[str, CheckedCase] = {}
    for case in checked:
        graph = ", ".join(filter(None, (case.name, case.variant.condition)))
        same = first.setdefault((graph, case.identity), case)
        before = base.setdefault(graph, case).uses
        yield Case(
            graph=graph,
            source=case.name,
            variant=case.variant.called,
            labels=case.variant.labels,
            sets=case.sets,
            tuned=settings_of(case.variant.sets),
            is_base=case.variant.is_base,
            role=case.role,
            folder=f"{RUNS}/{of_graph[case.name]}/{of_variant[same.variant.name]}",
            same_as="" if same is case else same.variant.called,
            uses=case.uses,
            swapped=tuple(stage for stage, use in case.uses.items() if before.get(stage) != use),
            notices=case.notices,
            graph_yaml=resolved_yaml(case.graph),
        )
