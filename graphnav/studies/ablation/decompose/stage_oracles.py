"""Find the oracles of the stages that drive."""

from __future__ import annotations

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Place, UserError
from graphnav.core.graph import Graph
from graphnav.studies.ablation.plan import driving_stages

_BY_HAND = "swap them with --vary, as in --vary plane=plane.ica,plane.truth"


def stage_oracles(graph: Graph, catalog: Catalog, place: Place) -> dict[str, str]:
    """Return the oracle of every driving stage whose family has one, by stage in firing order.

    A family's oracle is its one stage whose role is oracle. A stage that is an oracle has none.

    Raises
    ------
    UserError
        Nothing drives, the graph has no true data, no family has an oracle or one has several, or all are oracles.
    """
    _check_world(graph, place)
    driving = [node for node in graph.order if node.name in driving_stages(graph)]
    families = dict.fromkeys(node.use.partition(".")[0] for node in driving)
    oracles = {family: _oracles(family, catalog) for family in families}
    for family, found in oracles.items():
        if len(found) > 1:
            what = f"the family '{family}' has {len(found)} oracles: {', '.join(found)}"
            raise UserError.of(what, _BY_HAND, place)
    if not any(oracles.values()):
        what = f"no family of the stages that drive has an oracle: {', '.join(families)}"
        raise UserError.of(what, 'write a stage of one of them with role = "oracle"', place)
    swapped = {
        node.name: found[0]
        for node in driving
        if node.stage_class.role != "oracle" and (found := oracles[node.use.partition(".")[0]])
    }
    if not swapped:
        names = [f"{node.name} ({node.use})" for node in driving if node.stage_class.role == "oracle"]
        what = f"'{graph.path.stem}' is driven by oracles already: {', '.join(names)}"
        raise UserError.of(what, "name a graph that a method drives: corridor_ccw", place)
    return swapped


def _check_world(graph: Graph, place: Place) -> None:
    if not driving_stages(graph):
        what = f"nothing drives in '{graph.path.stem}': no source reads what a stage publishes"
        raise UserError.of(what, "name a graph whose robot is a simulated world: corridor_ccw", place)
    names = {source.name for source in graph.sources}
    if not any(channel.message.is_truth for channel in graph.channels.values() if channel.stage in names):
        what = f"'{graph.path.stem}' has no true data: no source of it publishes any"
        raise UserError.of(what, "name a graph whose robot is a simulated world: corridor_ccw", place)


def _oracles(family: str, catalog: Catalog) -> list[str]:
    uses = (f"{family}.{name}" for name in catalog.names(family))
    return [use for use in uses if catalog.stage(use).role == "oracle"]
