"""Small plans and records made by hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import pytest

from graphnav.ablation.plan.plan import Better, Case, Plan
from graphnav.ablation.results.records import Record, StageTime
from graphnav.graph import parse_override

MakePlan = Callable[..., Plan]
MakeRecord = Callable[..., Record]


def case_of(graph: str, variant: str, *, is_base: bool, same_as: str = "") -> Case:
    return Case(
        graph=graph,
        source=graph,
        variant=variant,
        labels={"plane": variant},
        overrides=() if is_base else (parse_override(f"plane=plane.{variant}"),),
        is_base=is_base,
        role="method",
        folder=f"{graph}/{same_as or variant}",
        same_as=same_as,
        uses={"plane": f"plane.{variant}", "drive": "score.navigation"},
        swapped=() if is_base else ("plane",),
        notices=(),
        graph_yaml="",
    )


@pytest.fixture
def make_plan() -> MakePlan:
    """Return what makes a plan; the first variant is the base, ``same_as`` shares the runs of another."""

    def make(
        variants: Sequence[str] = ("ica", "affine"),
        seeds: Sequence[int] = (0, 1, 2),
        figures: Mapping[str, Better] | None = None,
        graphs: Sequence[str] = ("corridor",),
        same_as: Mapping[str, str] | None = None,
        less_is_better: tuple[str, ...] = (),
    ) -> Plan:
        shared = same_as or {}
        return Plan(
            name="toy",
            about="Which one?",
            command="graphnav ablate toy --seeds 0:3",
            graphs=tuple(graphs),
            axes={"plane": tuple(variants)},
            seeds=tuple(seeds),
            figures=figures or {},
            cases=tuple(
                case_of(graph, variant, is_base=variant == variants[0], same_as=shared.get(variant, ""))
                for graph in graphs
                for variant in variants
            ),
            less_is_better=less_is_better,
            versions={"graphnav": "0.1.0"},
        )

    return make


@pytest.fixture
def make_record() -> MakeRecord:
    """Return what makes a record of a variant and a seed with some figures."""

    def make(
        variant: str,
        seed: int,
        figures: Mapping[str, float] | None = None,
        graph: str = "corridor",
        outcome: str = "goal",
        failure: str = "",
        p50_ms: float = 1.0,
    ) -> Record:
        return Record(
            graph=graph,
            variant=variant,
            seed=seed,
            outcome=outcome,
            failure=failure,
            frames=10,
            sim_s=0.9,
            metrics=figures or {},
            wall_s=0.1,
            times={"plane": StageTime(9, p50_ms, 2 * p50_ms)},
            folder=f"{graph}/{variant}/{seed}",
        )

    return make
