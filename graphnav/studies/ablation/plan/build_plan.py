"""Check a study before anything runs, and return its plan."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from graphnav import Graph, Role, UserError
from graphnav.core.catalog import Catalog
from graphnav.core.graph import resolved_yaml
from graphnav.core.runner import Summary
from graphnav.studies.ablation.plan.checked_cases import CaseProblems, CheckedCase, check_cases, stage_classes
from graphnav.studies.ablation.plan.plan import RUNS, Case, Plan
from graphnav.studies.ablation.plan.study_problems import checked_metrics, declared_metrics, study_problems
from graphnav.studies.ablation.plan.upstream import measured_stages
from graphnav.studies.ablation.plan.variants import Variant, expand
from graphnav.studies.ablation.study import MetricExpression, Study

_LONGEST = 100
_OTHER = re.compile(r"[^A-Za-z0-9._+=-]+")


def folder_names(texts: Iterable[str], called: Callable[[str], str] = str) -> dict[str, str]:
    """Return a folder name for each string: portable characters, unique even where letter case is ignored.

    A name is made of the label that ``called`` returns for the string. Where strings would share a name, or it had to
    be shortened, it ends in a hash of the string.
    """
    found = {text: _slug(called(text)) for text in texts}
    times = Counter(name.casefold() for name in found.values())
    return {
        text: name if name and times[name.casefold()] == 1 and len(name) <= _LONGEST else _hashed(text, name)
        for text, name in found.items()
    }


def _slug(text: str) -> str:
    return _OTHER.sub("_", text.replace(" + ", "+").replace("/", "_")).strip("._-")


def _hashed(text: str, name: str) -> str:
    return f"{name[:_LONGEST].rstrip('._-')}-{hashlib.sha256(text.encode()).hexdigest()[:8]}".lstrip("-")


_ROLES: tuple[Role, ...] = ("oracle", "baseline")
"""The most special one first."""


def variant_roles(cases: Sequence[CheckedCase], columns: Sequence[str]) -> list[Role]:
    """Return the role of every case; ``columns``: the study's metrics, the one that decides first, or none for all.

    A variant is an oracle if an oracle is among the stages that its first metric measures: for a score of the drive all
    that commands the robot, for a score of another stage what this is made from, up to the sources. Where that is the
    same in all variants of a graph, as the drive of a graph that compares detectors on it, it does not count. Stages
    that the variant's axes put in count wherever they are, also as baselines.
    """
    roles: list[Role] = []
    measured = [_measured(case.graph, columns) for case in cases]
    different: dict[str, set[object]] = {}
    for case, stages in zip(cases, measured, strict=True):
        different.setdefault(case.name, set()).add(case.identity_of(stages))
    for case, stages in zip(cases, measured, strict=True):
        is_varied = len(different[case.name]) > 1
        oracles = {role for role in case.roles_of(stages) if role == "oracle"} if is_varied else set()
        found = case.roles_of(case.swapped) | oracles
        roles.append(next((role for role in _ROLES if role in found), "method"))
    return roles


def _measured(graph: Graph, columns: Sequence[str]) -> frozenset[str]:
    """Return the stages that the first metric measures of those that the graph has."""
    names = {node.name for node in graph.nodes}
    for column in columns:
        scores = [operand.partition(".")[0] for operand in MetricExpression.parse(column).operands]
        if names.issuperset(scores):
            return frozenset(stage for score in scores for stage in measured_stages(graph, score))
    scores = [name for name in graph.metrics if graph.node(name).stage_class.role == "score"]
    return measured_stages(graph, scores[0]) if scores and not columns else frozenset()


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
        versions=Summary.versions_here(),
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
            driving=tuple(node.name for node in case.graph.order if node.name in case.driving),
            drives_as=drivers.setdefault((graph, case.drive), case.variant.called),
        )
