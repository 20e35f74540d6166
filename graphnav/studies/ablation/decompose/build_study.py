"""The study that swaps the stages of a drive for their oracles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Place, UserError
from graphnav.core.graph import Graph, Override, Target, load_graph
from graphnav.core.stage import Metric
from graphnav.studies.ablation.decompose.common_drive import common_drive
from graphnav.studies.ablation.decompose.stage_oracles import stage_oracles
from graphnav.studies.ablation.study import Axis, Choice, Decomposition, MetricExpression, Study
from graphnav.studies.ablation.study.study import AXIS, BASE, COMMON, CONDITION, OWN

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
