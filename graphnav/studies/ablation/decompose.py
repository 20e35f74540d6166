"""Turn a graph into the study of what each stage of its drive costs: its stages swapped for their oracles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from graphnav import Graph, Message, Metric, Place, UserError
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override, Target, load_graph
from graphnav.core.stage import Port, ports_of
from graphnav.studies.ablation.plan import driving_stages
from graphnav.studies.ablation.study import Axis, Choice, Decomposition, MetricExpression, Study
from graphnav.studies.ablation.study.study import AXIS, BASE, COMMON, CONDITION, OWN

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
    families = dict.fromkeys(node.family for node in driving)
    oracles = {family: _oracles(family, catalog) for family in families}
    for family, found in oracles.items():
        if len(found) > 1:
            what = f"the family '{family}' has {len(found)} oracles: {', '.join(found)}"
            raise UserError.of(what, _BY_HAND, place)
    if not any(oracles.values()):
        what = f"no family of the stages that drive has an oracle: {', '.join(families)}"
        raise UserError.of(what, 'write a stage of one of them with role = "oracle"', place)
    swapped = {
        node.name: found[0] for node in driving if node.stage_class.role != "oracle" and (found := oracles[node.family])
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


_PREFIX = "oracle_"


def common_drive(
    name: str, overrides: tuple[Override, ...], oracles: Mapping[str, str], catalog: Catalog, place: Place
) -> tuple[Override, ...] | None:
    """Return what lets the last stage's oracle drive a graph, the same for all variants; None if that cannot be.

    What still reads one of the other stages and drives, as a guard does, gets an oracle of its own in their place. What
    an oracle does not publish is left out where the reader goes without.
    """
    *others, last = oracles
    found = [Override(Target("stage", (last,)), oracles[last], place)]
    graph = load_graph(name, catalog, (*Override.without_replaced(overrides, found), *found))
    added: dict[str, None] = {}
    for stage, port, read in _reads(graph, set(others)):
        outputs = _outputs(catalog, oracles[read], port.message)
        if len(outputs) > 1 or not (outputs or port.may_be_open):
            return None
        if outputs:
            added[read] = None
        wire = f"{_PREFIX}{read}.{outputs[0]}" if outputs else None
        found.append(Override(Target("wire", (stage,), port.name), wire, place))
    found += [Override(Target("add", (f"{_PREFIX}{read}",)), oracles[read], place) for read in added]
    graph = load_graph(name, catalog, (*Override.without_replaced(overrides, found), *found))
    return tuple(found) if driving_stages(graph).isdisjoint(others) else None


def _reads(graph: Graph, stages: set[str]) -> Iterator[tuple[str, Port, str]]:
    """Yield who reads what of some stages and drives: stage, port, the stage that is read."""
    driving = driving_stages(graph)
    for node in graph.nodes:
        for i in node.inputs if node.name in driving - stages else ():
            if i.channel is not None and i.channel.stage in stages:
                yield node.name, i.port, i.channel.stage


def _outputs(catalog: Catalog, use: str, message: type[Message]) -> list[str]:
    """Return the outputs of a stage that carry a message."""
    return [port.name for port in ports_of(catalog.stage(use)).outputs if port.message is message]


PLACE = Place("--decompose")


def decomposed_study(study: Study, catalog: Catalog) -> Study:
    """Return a study of graphs with the axis of their oracles: one stage at a time, and cumulatively.

    Where a metric depends on the frames that a run meets, the variants are also measured on one drive, the oracle's.

    Raises
    ------
    UserError
        The study has axes of its own, or its graphs have no oracles, different ones, or no metric to show.
    """
    if study.axes:
        names = ", ".join(axis.name for axis in study.axes)
        raise UserError.of(f"the study varies {names} already", "name a graph, and no --vary", PLACE)
    if study.one_at_a_time:
        what = "one at a time is for axes; a decomposition swaps one stage at a time, and cumulatively"
        raise UserError.of(what, "leave out --one-at-a-time", PLACE)
    if study.within:
        raise UserError.of(
            "within is for axes that are conditions; a decomposition has none", "leave out --within", PLACE
        )
    if not study.graphs:
        raise UserError.of("no graph is named", "name one: graphnav ablate corridor_ccw --decompose", PLACE)
    graphs = {name: load_graph(name, catalog, study.overrides) for name in study.graphs}
    oracles = _common_oracles(graphs, catalog)
    columns = study.metrics or _key_metrics(next(iter(graphs.values())))
    is_of_frames = any(metric.of_frames for graph in graphs.values() for metric in _declared(graph, columns))
    drive = common_drive(study.graphs[0], study.overrides, oracles, catalog, PLACE) if is_of_frames else None
    decomposition = Decomposition(oracles, has_common_drive=drive is not None)
    axes = [Axis(AXIS, tuple(_choices(decomposition)), PLACE)]
    if drive is not None:
        axes.append(Axis(CONDITION, (Choice(OWN, (), PLACE), Choice(COMMON, drive, PLACE)), PLACE))
    return replace(
        study,
        name=f"{study.name}_decomposed",
        about=f"Which stages lose what their oracles reach on {', '.join(study.graphs)}?",
        axes=tuple(axes),
        metrics=columns,
        within=(CONDITION,) if drive is not None else (),
        decomposition=decomposition,
    )


def _common_oracles(graphs: Mapping[str, Graph], catalog: Catalog) -> dict[str, str]:
    """Return the oracles of the graphs; raises UserError where these differ."""
    found = {name: stage_oracles(graph, catalog, PLACE) for name, graph in graphs.items()}
    (first, oracles), *others = found.items()
    for name, other in others:
        if list(other.items()) != list(oracles.items()):
            what = f"{first} swaps {', '.join(oracles)}, but {name} swaps {', '.join(other)}"
            raise UserError.of(what, "decompose them one by one", PLACE)
    return oracles


def _choices(decomposition: Decomposition) -> Iterator[Choice]:
    yield Choice(BASE, (), PLACE)
    for variant in dict.fromkeys((*decomposition.single, *decomposition.cumulative)):
        stages = decomposition.stages_of(variant)
        swaps = (Override(Target("stage", (stage,)), decomposition.oracles[stage], PLACE) for stage in stages)
        yield Choice(variant, tuple(swaps), PLACE)


def _key_metrics(graph: Graph) -> tuple[str, ...]:
    found = tuple(f"{stage}.{name}" for stage, of in graph.metrics.items() for name, m in of.items() if m.is_key)
    if not found:
        what = f"no stage of '{graph.path.stem}' declares a metric that sums up a drive"
        raise UserError.of(what, "name what to show: --metrics drive.success", PLACE)
    return found


def _declared(graph: Graph, columns: tuple[str, ...]) -> Iterator[Metric]:
    for column in columns:
        for operand in MetricExpression.parse(column).operands:
            stage, _, name = operand.partition(".")
            if metric := graph.metrics.get(stage, {}).get(name):
                yield metric
