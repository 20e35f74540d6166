"""Whether two plans have the same properties that runs depend on beside their graph."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from graphnav import UserError
from graphnav.core.machine import expected_instruction_set
from graphnav.core.runner import CODE, Summary, difference, files_of_graphs, provenance
from graphnav.core.spec import parse_yaml
from graphnav.studies.ablation.plan.build_plan import CheckedStudy
from graphnav.studies.ablation.plan.plan import Case, Plan


def with_versions(checked: CheckedStudy) -> CheckedStudy:
    """Return the study with all that its runs depend on: versions, the code of its stages, and the files they read."""
    plan = checked.plan
    families = {use.partition(".")[0] for case in plan.cases for use in case.uses.values()}
    versions = provenance(families, plan.plugins) | files_of_graphs(checked.graphs.values())
    versions |= {Summary.INSTRUCTION_SET: expected_instruction_set()}
    return replace(checked, plan=replace(plan, versions=versions))


def check_compatible(old: Plan, new: Plan, folder: Path) -> None:
    """Let seeds and metrics grow and shrink, and variants be added; refuse everything that changes what a run is.

    Raises
    ------
    UserError
        The study in ``folder`` is another one, or its runs were made from other graphs, plugins or versions.
    """
    hint = f"choose another folder with -o, or remove {folder}"
    if old.name != new.name:
        raise UserError.of(f"{folder} holds the study '{old.name}', not '{new.name}'", hint)
    cases = {(case.graph, case.variant): case for case in new.cases}
    for case in old.cases:
        now = cases.get((case.graph, case.variant))
        if now is None:
            what = f"{folder} holds another study of this name: it has {case.graph} with {case.variant}"
            raise UserError.of(what, hint)
        if change := _change_of(case, now):
            what = f"{case.graph} with {case.variant} has changed since its runs in {folder} were made"
            raise UserError.of(f"{what}: {change}", hint)
    if old.base != new.base:
        raise UserError.of(f"{folder} holds a study whose base is {old.base}, not {new.base}", hint)
    if other := difference(old.versions, new.versions):
        raise UserError.of(f"the runs in {folder} were made with {other}", other.hint or hint)


def _change_of(old: Case, new: Case) -> str:
    """Return what differs between the graphs of a case, empty if nothing does."""
    if old.graph_yaml != new.graph_yaml:
        return _first_change(old.graph_yaml.splitlines(), new.graph_yaml.splitlines())
    if old.folder != new.folder:
        return f"they were to be in {old.folder}, now in {new.folder}"
    return ""


def _first_change(old: list[str], new: list[str]) -> str:
    """Return the first line that differs and, if it is of the same key, what stands there now."""
    matcher = difflib.SequenceMatcher(None, old, new, autojunk=False)
    begin_old, end_old, begin_new, end_new = next(span for tag, *span in matcher.get_opcodes() if tag != "equal")
    was, now = ([*lines, ""][0].strip() for lines in (old[begin_old:end_old], new[begin_new:end_new]))
    if was and now and was.partition(":")[0] != now.partition(":")[0]:
        now = ""
    return f"'{was}' was, '{now}' is" if was and now else f"'{was}' was, and is not" if was else f"'{now}' is new"


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
