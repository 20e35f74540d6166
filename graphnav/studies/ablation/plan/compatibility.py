"""Check that existing runs and pending runs belong to one study."""

from __future__ import annotations

import difflib
from pathlib import Path

from graphnav.core.errors import UserError
from graphnav.studies.ablation.plan.plan import Case, Plan
from graphnav.studies.ablation.plan.provenance import difference


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
        lines = difflib.ndiff(old.graph_yaml.splitlines(), new.graph_yaml.splitlines())
        changed = [line for line in lines if line[0] in "+-"]
        was, now = (next((line[2:].strip() for line in changed if line[0] == sign), "nothing") for sign in "-+")
        return f"'{was}' was, '{now}' is"
    if old.folder != new.folder:
        return f"they were to be in {old.folder}, now in {new.folder}"
    return ""
