"""The studies that compare two simulators: what they set is what the graphs that ship have."""

from __future__ import annotations

from dataclasses import replace

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph, load_graph
from graphnav.studies.ablation.plan import check_study
from graphnav.studies.ablation.study.study_file import load_study


def by_method(name: str, catalog: Catalog, graph: str) -> dict[str, Graph]:
    """Return the graph of each method in the first simulator."""
    study = load_study(name)
    method, simulator = study.axes
    ours = replace(simulator, choices=simulator.choices[:1])
    study = replace(study, graphs=(graph,), axes=(method, ours), within=(), seeds=(1,), worlds={})
    checked = check_study(study, catalog, "")
    return {case.variant.removesuffix(" + pymunk"): checked.graphs[case.folder] for case in checked.plan.cases}


def stages_of(graph: Graph) -> dict[str, tuple[str, dict[str, object], dict[str, str | None]]]:
    """Return what each stage is: its ``use``, parameters and inputs."""
    return {
        node.name: (
            node.use,
            dict(node.params),
            {one.port.name: None if one.channel is None else one.channel.ref for one in node.inputs},
        )
        for node in graph.nodes
    }


@pytest.mark.long
@pytest.mark.parametrize("world", ["corners", "doors", "poles"])
def test_navigate_of_the_suite_is_the_graph_that_ships(world: str) -> None:
    catalog = Catalog()
    methods = by_method("referee", catalog, f"suite/{world}")
    assert stages_of(methods["navigate"]) == stages_of(load_graph(f"navigate/{world}", catalog))
    assert stages_of(methods["chain"]) == stages_of(load_graph(f"suite/{world}", catalog))


@pytest.mark.long
def test_the_worlds_of_barn_are_for_tuning() -> None:
    catalog = Catalog()
    methods = by_method("referee_barn", catalog, "barn_navigate")
    assert stages_of(methods["navigate"]) == stages_of(load_graph("barn_navigate", catalog))
    seeds = load_study("referee_barn").seeds
    worlds = {seed % 300 for seed in seeds}
    assert len(worlds) == 12
    assert all(world % 3 for world in worlds)
    assert len(seeds) == len(set(seeds)) == 60
