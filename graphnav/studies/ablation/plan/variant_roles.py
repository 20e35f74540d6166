"""The roles of a study's variants."""

from __future__ import annotations

from collections.abc import Sequence

from graphnav.core.graph import Graph
from graphnav.core.stage import Role
from graphnav.studies.ablation.plan.checked_cases import CheckedCase
from graphnav.studies.ablation.plan.upstream import measured_stages
from graphnav.studies.ablation.study import MetricExpression

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
