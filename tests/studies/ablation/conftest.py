"""Small plans and records made by hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import pytest

from graphnav.core.graph import Override
from graphnav.core.stage import Better, Metric
from graphnav.studies.ablation.plan.plan import Case, Plan
from graphnav.studies.ablation.results.records import Record, StageTime
from graphnav.studies.ablation.study.study import MetricExpression

MakePlan = Callable[..., Plan]
MakeRecord = Callable[..., Record]


DRIVE: dict[str, Metric] = {
    "drive.success": Metric(
        "success", help="Arrived.", better="higher", if_failed=0.0, is_outcome=True, min_difference=0.05
    ),
    "drive.spl": Metric("spl", help="Weighted by path length.", better="higher", if_failed=0.0),
    "drive.path_length_m": Metric("path_length_m", help="Path.", better="lower", unit="m", if_failed="undefined"),
}


def declared_of(columns: Mapping[str, Better]) -> dict[str, Metric]:
    """Return declarations of the metrics of columns; of a drive's they are known."""
    names = {name: better for text, better in columns.items() for name in MetricExpression.parse(text).operands}
    units = {name: "s" if name.endswith("_s") else "" for name in names}
    return {
        name: DRIVE.get(name) or Metric(name.partition(".")[2], help="Toy.", better=better, unit=units[name])
        for name, better in names.items()
    }


def case_of(graph: str, variant: str, *, is_base: bool, same_as: str = "") -> Case:
    return Case(
        graph=graph,
        source=graph,
        variant=variant,
        labels={"plane": variant},
        overrides=() if is_base else (Override.parse(f"plane=plane.{variant}"),),
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
        metrics: Mapping[str, Better] | None = None,
        graphs: Sequence[str] = ("corridor",),
        same_as: Mapping[str, str] | None = None,
        lower: tuple[str, ...] = (),
    ) -> Plan:
        shared = same_as or {}
        return Plan(
            name="toy",
            about="Which one?",
            command="graphnav ablate toy --seeds 0:3",
            graphs=tuple(graphs),
            axes={"plane": tuple(variants)},
            seeds=tuple(seeds),
            metrics=tuple(metrics or {}),
            cases=tuple(
                case_of(graph, variant, is_base=variant == variants[0], same_as=shared.get(variant, ""))
                for graph in graphs
                for variant in variants
            ),
            declared={**DRIVE, **declared_of(metrics or {}), **declared_of(dict.fromkeys(lower, "lower"))},
            versions={"graphnav": "0.1.0"},
        )

    return make


@pytest.fixture
def make_record() -> MakeRecord:
    """Return what makes a record of a variant and a seed with some metrics."""

    def make(
        variant: str,
        seed: int,
        metrics: Mapping[str, float] | None = None,
        graph: str = "corridor",
        outcome: str = "goal",
        failure: str = "",
        cause: str = "",
        p50_ms: float = 1.0,
    ) -> Record:
        return Record(
            graph=graph,
            variant=variant,
            seed=seed,
            outcome=outcome,
            failure=failure,
            cause=cause or failure,
            frames=10,
            sim_s=0.9,
            metrics=metrics or {},
            wall_s=0.1,
            times={"plane": StageTime(9, p50_ms, 2 * p50_ms)},
            folder=f"{graph}/{variant}/{seed}",
        )

    return make
