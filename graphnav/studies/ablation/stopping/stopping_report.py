"""Sentences on a study that was stopped by its results."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.results import ALPHA, Record
from graphnav.studies.ablation.stopping.rounds import ROUND, decisions


def stopping_texts(plan: Plan, records: Sequence[Record]) -> Iterator[str]:
    """Yield how the number of worlds was decided and when each variant was; nothing for other studies."""
    if not plan.until_clear:
        return
    metric = plan.metrics[0]
    yield (
        f"Stopped by --until-clear: {ROUND} worlds at a time were added until {metric} told each variant from the "
        f"base, with at most {ALPHA:.0%} for any false decision on a graph at any time (betting e-process, Holm). The "
        "intervals of the tables are for a number of worlds that was set before; means at a stop lean away from 0."
    )
    for graph in plan.graphs:
        for decision in decisions(plan, graph, records):
            state = "told" if decision.is_told else "not told"
            small = ", by a difference smaller than what matters" if decision.is_told and not decision.matters else ""
            yield f"{graph}, {decision.case.variant}: {state} from the base after {decision.worlds} worlds{small}"
