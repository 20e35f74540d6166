"""``--set name+=family.stage``: add a stage to a graph."""

from __future__ import annotations

from collections.abc import Collection

from graphnav.core.catalog import Catalog
from graphnav.core.errors import CatalogError
from graphnav.core.graph.overrides.assignment import Assignment
from graphnav.core.graph.overrides.carry_over import params_notice
from graphnav.core.spec import Spec, StageSpec


def add_stage(spec: Spec, added: Assignment, catalog: Catalog, given: Collection[str], notices: list[str]) -> None:
    """Add a stage without wires behind all others; ``given``: its parameters that are set too."""
    spec.stages[added.stage] = StageSpec(
        name=added.stage, place=added.place, use=added.text, use_place=added.place, use_note=added.override.note
    )
    try:
        cls = catalog.stage(added.text)
    except CatalogError:
        return  # reported by the check of the graph
    notices.append(params_notice(f"{added.stage}: added, {added.text}", cls, given=given))
