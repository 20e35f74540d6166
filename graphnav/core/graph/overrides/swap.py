"""Apply overrides: swap and add stages, rewire what that leaves open, prune what no stage reads any more."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import suppress

from graphnav.core.catalog import Catalog
from graphnav.core.errors import CatalogError, Problem
from graphnav.core.graph.overrides.assignment import Assignment, assign
from graphnav.core.graph.overrides.carry_over import kept_params, kept_wires, lost_wires, params_notice, written_out
from graphnav.core.graph.overrides.override import Override
from graphnav.core.graph.overrides.prune import prune
from graphnav.core.graph.overrides.rewire import Rewiring
from graphnav.core.graph.wiring.stage_class import stage_class
from graphnav.core.spec import Spec, StageSpec, time_problems


def apply_overrides(
    spec: Spec,
    overrides: Sequence[Override],
    catalog: Catalog,
    problems: list[Problem],
    notices: list[str],
    *,
    prunes: bool = True,
) -> Spec:
    """Return ``spec`` with overrides applied; what is wrong and what changed is added to the lists.

    ``prunes``: whether stages that no other stage reads any more are removed.
    """
    spec.folders |= {o.place.file: o.folder for o in overrides if o.folder is not None}
    assignments = assign(overrides, spec, problems)
    if any(a.kind in ("swap", "add") for a in assignments):
        _Change(spec, assignments, catalog, problems, notices).apply(prunes=prunes)
    for a in assignments:
        if a.kind == "run":
            spec.run[a.key] = a.entry
        elif a.kind in ("param", "time", "wire") and a.stage not in spec.stages:
            notices.append(f"{a.stage}: pruned, so that '{a.override.note}' changes nothing")
        elif a.kind == "param":
            spec.stages[a.stage].params[a.key] = a.entry
        elif a.kind == "time":
            _set_time(spec.stages[a.stage], a, problems)
        elif a.kind == "wire":
            spec.stages[a.stage].wires[a.key] = a.entry
            spec.stages[a.stage].wire_notes[a.key] = a.override.note
    return spec


def _set_time(stage: StageSpec, given: Assignment, problems: list[Problem]) -> None:
    found = time_problems(stage.name, given.key, given.entry.value)
    if not found:
        stage.times[given.key] = given.entry
    stage.has_timer |= given.key == "every_ms"
    problems += found


class _Change:
    """Adds and swaps stages of one graph. Wires are kept where name and type of the port are the same."""

    def __init__(
        self,
        spec: Spec,
        assignments: Sequence[Assignment],
        catalog: Catalog,
        problems: list[Problem],
        notices: list[str],
    ) -> None:
        self._spec, self._catalog, self._notices = spec, catalog, notices
        self._adds = [a for a in assignments if a.kind == "add"]
        self._swaps = [a for a in assignments if a.kind == "swap"]
        self._wires = {(a.stage, a.key): a for a in assignments if a.kind == "wire"}
        self._params = {(a.stage, a.key): a.entry for a in assignments if a.kind == "param"}
        self._rewiring = Rewiring(spec, catalog, self._wires.keys(), problems, notices)
        self._before = self._rewiring.classes()

    def apply(self, *, prunes: bool) -> None:
        """Add, swap, rewire, prune."""
        if self._swaps:
            self._write_out_references()
        read_before = {ref.partition(".")[0] for _, _, ref in self._rewiring.wires()} if prunes else set()
        swaps_of_added = {a.stage: a for a in self._swaps}
        for a in self._adds:
            _add_stage(self._spec, swaps_of_added.pop(a.stage, a), self._catalog, self._given(a.stage), self._notices)
            self._declare_ports(self._spec.stages[a.stage])
        swapped = [a.stage for a in swaps_of_added.values() if self._replace(a)]
        for given in self._wires.values():
            self._spec.stages[given.stage].wires[given.key] = given.entry
        self._rewiring.rewire(swapped, [a.stage for a in self._adds])
        if swaps_of_added:
            prune(self._spec, read_before, set(swapped), self._rewiring.classes(), self._notices)

    def _given(self, stage: str) -> list[str]:
        """Return the parameters of a stage that are set too."""
        return [key for name, key in self._params if name == stage]

    def _declare_ports(self, stage: StageSpec) -> None:
        """Set the parameters that declare the ports of a new stage: it is wired before the others are set."""
        with suppress(CatalogError):  # reported by the check of the graph
            names = self._catalog.stage(stage.use).ports_from
            stage.params |= {key: self._params[stage.name, key] for key in names if (stage.name, key) in self._params}

    def _replace(self, swap: Assignment) -> bool:
        stage = self._spec.stages[swap.stage]
        if stage.use == swap.text:
            self._notices.append(f"{stage.name}: it is {swap.text} already")
            return False
        old_use, old = stage.use, self._before.get(stage.name)
        stage.use, stage.use_place, stage.use_note = swap.text, swap.place, swap.override.note
        try:
            new = self._catalog.stage(swap.text)
        except CatalogError:
            return False  # reported by the check of the graph
        kept = kept_params(stage.params, old, new)
        lost = [name for name in stage.params if name not in kept]
        stage.params = kept
        self._declare_ports(stage)
        new = stage_class(stage, self._catalog, []) or new
        what = f"{stage.name}: {old_use} swapped for {swap.text}"
        self._notices.append(params_notice(what, new, kept, lost, self._given(stage.name)))
        self._notices += lost_wires(stage.name, stage.wires, new)
        stage.wires = kept_wires(stage.wires, old, new)
        return True

    def _write_out_references(self) -> None:
        """Turn references to a stage's one output from ``stage`` into ``stage.port``."""
        for stage in self._spec.stages.values():
            stage.wires = {name: written_out(entry, self._before) for name, entry in stage.wires.items()}


def _add_stage(spec: Spec, added: Assignment, catalog: Catalog, given: Collection[str], notices: list[str]) -> None:
    """Add a stage without wires behind all others; ``given``: its parameters that are set too."""
    spec.stages[added.stage] = StageSpec(
        name=added.stage, place=added.place, use=added.text, use_place=added.place, use_note=added.override.note
    )
    try:
        cls = catalog.stage(added.text)
    except CatalogError:
        return  # reported by the check of the graph
    notices.append(params_notice(f"{added.stage}: added, {added.text}", cls, given=given))
