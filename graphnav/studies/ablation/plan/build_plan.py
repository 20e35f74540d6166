"""Check a study before anything runs: its plan, and the graph of every case."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from graphnav.core.catalog import Catalog
from graphnav.core.errors import UserError
from graphnav.core.graph import Graph, resolved_yaml
from graphnav.core.runner.recording.summary import versions
from graphnav.studies.ablation.plan.case_problems import CaseProblems
from graphnav.studies.ablation.plan.checked_cases import CheckedCase, check_cases, stage_classes
from graphnav.studies.ablation.plan.folder_names import folder_names
from graphnav.studies.ablation.plan.metric_checks import checked_metrics, declared_metrics
from graphnav.studies.ablation.plan.plan import RUNS, Case, Plan
from graphnav.studies.ablation.plan.study_problems import study_problems
from graphnav.studies.ablation.plan.upstream import driving_stages
from graphnav.studies.ablation.plan.variant_roles import variant_roles
from graphnav.studies.ablation.plan.variants import Variant, expand
from graphnav.studies.ablation.study import Study


@dataclass(frozen=True)
class CheckedStudy:
    """The plan of a study, and its graphs, loaded once."""

    plan: Plan
    graphs: Mapping[str, Graph]
    """The graph of every case with runs of its own, by `Case.folder`."""


def check_study(study: Study, catalog: Catalog, command: str, plugins: Sequence[Path] = ()) -> CheckedStudy:
    """Load and check every graph of a study with every variant.

    Costs about 10 ms a case, and what its stages take to look at their files. ``command`` and ``plugins`` are recorded
    in the plan for those who run it again.

    Raises
    ------
    UserError
        Everything that is wrong with the study and its graphs, each once.
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
    cases = tuple(_cases(study, variants, checked, metrics))
    plan = Plan(
        name=study.name,
        about=study.about,
        command=command,
        graphs=tuple(dict.fromkeys(case.graph for case in cases)),
        axes={axis.name: tuple(choice.label for choice in axis.choices) for axis in study.axes},
        seeds=study.seeds,
        metrics=metrics,
        cases=cases,
        reference=study.reference,
        worlds=study.worlds,
        within=study.within,
        declared=declared_metrics(classes),
        plugins=_plugins(plugins, checked),
        versions=versions(),
        decomposition=study.decomposition,
    )
    graphs = {case.folder: one.graph for case, one in zip(cases, checked, strict=True) if not case.same_as}
    return CheckedStudy(plan, graphs)


def _plugins(given: Sequence[Path], checked: Sequence[CheckedCase]) -> tuple[str, ...]:
    """Return the plugin files that are given and those that the graphs name, each once."""
    named = (path for case in checked for path in case.graph.plugins)
    return tuple(dict.fromkeys(str(path) for path in (*(path.resolve() for path in given), *named)))


def _cases(
    study: Study, variants: tuple[Variant, ...], checked: Sequence[CheckedCase], metrics: Sequence[str]
) -> Iterator[Case]:
    of_graph = folder_names(study.graphs, lambda name: Path(name).stem)
    of_variant = folder_names(variant.name for variant in variants)
    first: dict[object, CheckedCase] = {}
    base: dict[str, CheckedCase] = {}
    drivers: dict[object, str] = {}
    for case, role in zip(checked, variant_roles(checked, metrics), strict=True):
        graph = ", ".join(filter(None, (case.name, case.variant.condition)))
        same = first.setdefault((graph, case.identity), case)
        before = base.setdefault(graph, case).uses
        yield Case(
            graph=graph,
            source=case.name,
            variant=case.variant.called,
            labels=case.variant.labels,
            overrides=case.overrides,
            is_base=case.variant.is_base,
            role=role,
            folder=f"{RUNS}/{of_graph[case.name]}/{of_variant[same.variant.name]}",
            same_as="" if same is case else same.variant.called,
            uses=case.uses,
            swapped=tuple(stage for stage, use in case.uses.items() if before.get(stage) != use),
            notices=case.notices,
            graph_yaml=resolved_yaml(case.graph),
            driving=tuple(node.name for node in case.graph.order if node.name in driving_stages(case.graph)),
            drives_as=drivers.setdefault((graph, case.drive), case.variant.called),
        )
