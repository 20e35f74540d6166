"""Whether a case of two studies meets the same frames, as far as their plans show it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from graphnav.core.spec import parse_yaml
from graphnav.studies.ablation.plan.plan import Case, Plan
from graphnav.studies.ablation.plan.provenance import CODE


def shows_same_drive(plan_a: Plan, case_a: Case, plan_b: Plan, case_b: Case) -> bool:
    """Return whether two plans show that a case meets the same frames in both.

    What drives and the sources have to be the same stages with the same parameters, wires and hashes of their code,
    the run has to end at the same time, and all versions have to be the same: everything but the code of other stages.
    """
    if not (case_a.graph_yaml and case_b.graph_yaml):
        return False
    (drive_a, uses_a), (drive_b, uses_b) = _drive(case_a), _drive(case_b)
    families = {use.partition(".")[0] for use in (*uses_a, *uses_b)}
    return drive_a == drive_b and _versions(plan_a, families) == _versions(plan_b, families) != {}


def _drive(case: Case) -> tuple[Any, list[str]]:
    """Return what makes the frames of a resolved graph, and what its stages use."""
    value, _ = parse_yaml(case.graph_yaml.encode(), "graph.yaml")
    graph = value.plain()
    stages: Mapping[str, Any] = graph["stages"]
    sources = [name for name, stage in stages.items() if not stage.get("in")]
    found = {name: stages[name] for name in _upstream(stages, [*case.driving, *sources])}
    return (found, graph["run"].get("until_s"), graph.get("queues")), [stage["use"] for stage in found.values()]


def _upstream(stages: Mapping[str, Any], starts: Iterable[str]) -> set[str]:
    """Return stages and all that they read, directly or not."""
    found: set[str] = set()
    pending = list(starts)
    while pending:
        name = pending.pop()
        if name not in found and name in stages:
            found.add(name)
            pending += [str(wire).partition(".")[0] for wire in (stages[name].get("in") or {}).values()]
    return found


def _versions(plan: Plan, families: Iterable[str]) -> dict[str, str]:
    """Return all versions that frames depend on; none where the code of a family is not known."""
    code = {f"{CODE}{family}": plan.versions.get(f"{CODE}{family}", "") for family in families}
    if not plan.plugins and not all(code.values()):
        return {}
    return {name: version for name, version in plan.versions.items() if not name.startswith(CODE)} | code
