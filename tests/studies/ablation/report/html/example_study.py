"""A study with made-up results, for reports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override
from graphnav.core.stage import Metric, Role
from graphnav.studies.ablation.plan.plan import Case, Plan
from graphnav.studies.ablation.report.html.page import write_report
from graphnav.studies.ablation.results.compare_variants import compare
from graphnav.studies.ablation.results.records import Record, StageTime
from graphnav.studies.ablation.stopping import pending_runs

SUCCESS, CLEARANCE = "drive.success", "drive.min_clearance_m"
VOID = {"meta", "img", "br", "link", "input", "hr"}


class Page(HTMLParser):
    """Checks that every element is closed where it was opened, and gathers what would be loaded."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.loads: list[str] = []
        self.words: list[str] = []
        self.ids: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
            self.open.append(tag)
        assert tag not in {"script", "link", "iframe", "object", "embed", "base"}
        for name, value in attrs:
            assert not name.startswith("on")
            if name in {"src", "href", "xlink:href", "srcset", "data", "action", "poster"}:
                self.loads.append(value or "")
            if name == "id":
                self.ids.append(value or "")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "style" not in self.open:
            self.words.append(data)


def plan_of(
    variants: Mapping[str, Role],
    *,
    graphs: Sequence[str] = ("corridor",),
    seeds: Sequence[int] = tuple(range(20)),
    metrics: Sequence[str] = (SUCCESS, CLEARANCE),
    graph_yaml: str = "",
    same_as: Mapping[str, str] | None = None,
    axis: str = "plane",
    lower: Sequence[str] = (),
) -> Plan:
    """Return a plan whose first variant is the base; ``same_as`` shares the runs of another."""
    shared = same_as or {}
    cases = tuple(
        Case(
            graph=graph,
            source=graph,
            variant=variant,
            labels={axis: variant},
            overrides=(Override.parse(f"plane={variant}"),),
            is_base=place == 0,
            role=role,
            folder=f"runs/{graph}/{shared.get(variant, variant)}",
            same_as=shared.get(variant, ""),
            uses={"flow": "toy.matcher", "plane": f"toy.{variant}"},
            swapped=("plane",) if place else (),
            notices=("planar: nothing reads it",) if place else (),
            graph_yaml=graph_yaml,
        )
        for graph in graphs
        for place, (variant, role) in enumerate(variants.items())
    )
    return Plan(
        name="toy",
        about="Which one drives best?",
        command="graphnav ablate toy --seeds 0:20",
        graphs=tuple(graphs),
        axes={axis: tuple(variants)},
        seeds=tuple(seeds),
        metrics=tuple(metrics),
        cases=cases,
        declared={
            SUCCESS: Metric("success", help="Arrived.", better="higher", if_failed=0.0, is_outcome=True),
            **{name: Metric(name.partition(".")[2], help="Toy.", better="lower") for name in lower},
        },
        versions={"graphnav": "0.1.0"},
    )


def record_of(case: Case, seed: int, outcome: str, **metrics: float) -> Record:
    """Return a run of a case; ``drive__success=1.0`` is the metric ``drive.success``."""
    failure = "plane: it broke <down>" if outcome == "failed" else ""
    return Record(
        graph=case.graph,
        variant=case.variant,
        seed=seed,
        outcome=outcome,
        failure=failure,
        cause=failure,
        frames=10,
        sim_s=1.0 + seed,
        metrics={name.replace("__", "."): value for name, value in metrics.items()},
        wall_s=0.1,
        times={"flow": StageTime(9, 1.5, 3.0), "plane": StageTime(9, 0.5, 1.0)},
        folder=f"{case.folder}/{seed}",
    )


def records_of(plan: Plan, share: Mapping[str, float]) -> list[Record]:
    """Return runs of all cases; ``share``: of its worlds in which a variant reaches the goal, the first ones."""
    found = []
    for case in plan.cases:
        for place, seed in enumerate(plan.seeds):
            is_good = place < share[case.same_as or case.variant] * len(plan.seeds)
            outcome = "goal" if is_good else "contact"
            clearance = 0.2 + 0.001 * place if is_good else 0.0
            found.append(
                record_of(case, seed, outcome, drive__success=float(is_good), drive__min_clearance_m=clearance)
            )
    return found


def report(plan: Plan, records: Sequence[Record], folder: Path, catalog: Any = None) -> str:
    """Return the text of the report."""
    path = write_report(
        plan, compare(plan, records, pending_runs(plan, records)), records, folder, catalog or Catalog()
    )
    assert path == folder / "report.html"
    return path.read_text(encoding="utf-8")
