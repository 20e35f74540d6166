"""Decide the number of worlds by the results: add them until the deciding metric tells every variant from the base."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass

from graphnav import UserError
from graphnav.arrays import Doubles
from graphnav.studies.ablation.plan import Case, Job, Plan
from graphnav.studies.ablation.results import (
    ALPHA,
    Record,
    Values,
    anytime_p,
    holm,
    matters,
    paired_differences,
    scaled_values,
    values_of,
)
from graphnav.studies.ablation.study import MetricExpression

ROUND = 5
"""Worlds that are added at once."""


@dataclass(frozen=True)
class Decision:
    """The state of a variant's comparison with its base."""

    case: Case
    worlds: int
    """The number of worlds after which it was decided, or that there were without a decision."""
    is_told: bool
    """Whether it is told from the base."""
    matters: bool
    """Whether its mean difference in these worlds is not smaller than what matters."""


def check_stopping(plan: Plan) -> None:
    """Raise UserError unless the metric that decides has two bounds, as the rule needs, and compares all variants."""
    if not plan.metrics:
        raise UserError.of("--until-clear: the study names no metric to decide by", "add --metrics drive.success")
    column = MetricExpression.parse(plan.metrics[0])
    if column.operator or plan.metric(column.text).limits is None:
        bounded = [name for name, metric in plan.declared.items() if metric.limits is not None]
        known = f"metrics with both are {', '.join(bounded)}" if bounded else "no stage declares both"
        what = f"--until-clear: '{column.text}' decides, and its stage does not declare a lowest and a highest value"
        raise UserError.of(what, f"{known}; name one first in --metrics")
    bases = {case.graph: case for case in plan.cases if case.is_base}
    for case in plan.cases:
        if not plan.are_comparable(case, bases[case.graph], column.text):
            what = f"--until-clear: '{column.text}' decides, and {case.variant} meets frames of its own on {case.graph}"
            raise UserError.of(
                what, "compare detectors on one drive, as measure_detectors does, or decide by the drive"
            )


def jobs_of_next_round(plan: Plan, records: Sequence[Record], is_made: Callable[[Job], bool]) -> list[Job]:
    """Return the next runs of a study that is stopped by its results; none where every graph is decided.

    The base and every undecided variant of a graph get `ROUND` more of its seeds, in their order, and so does the
    reference where the metric that decides is relative to its runs: a world without one has no value for any variant.
    What is decided depends on the results of these worlds only, not on the order or the number of processes in which
    they are made.
    """
    return [job for graph in plan.graphs for job in _next_of_graph(plan, graph, records, is_made)]


def pending_runs(plan: Plan, records: Sequence[Record]) -> list[Job]:
    """Return the runs that a study still needs, given those that it has; none: it is finished."""
    made = {(record.graph, record.variant, record.seed) for record in records}

    def is_made(job: Job) -> bool:
        return (job.case.graph, job.case.variant, job.seed) in made

    if plan.until_clear:
        return jobs_of_next_round(plan, records, is_made)
    return [job for job in plan.jobs if not is_made(job)]


def decisions(plan: Plan, graph: str, records: Sequence[Record]) -> list[Decision]:
    """Return the state of each variant of a graph after the rounds that are complete."""
    made = {(record.graph, record.variant, record.seed) for record in records}
    return _Graph(plan, graph, records).decided(lambda job: (graph, job.case.variant, job.seed) in made)[0]


def _next_of_graph(plan: Plan, graph: str, records: Sequence[Record], is_made: Callable[[Job], bool]) -> list[Job]:
    return _Graph(plan, graph, records).decided(is_made)[1]


class _Graph:
    """The cases of a graph and their results."""

    def __init__(self, plan: Plan, graph: str, records: Sequence[Record]) -> None:
        own = [case for case in plan.cases if case.graph == graph and not case.same_as]
        self.base = next(case for case in own if case.is_base)
        self.others = [case for case in own if not case.is_base]
        self.seeds = plan.seeds_of(self.base)
        self._always = [self.base, *(case for case in self.others if _is_needed(plan, case))]
        self._values = {case.variant: _values(plan, case, records) for case in own}
        low, high = plan.metric(plan.metrics[0]).limits or (0.0, 1.0)
        self._min_share = plan.min_difference(plan.metrics[0]) / (high - low)

    def decided(self, is_made: Callable[[Job], bool]) -> tuple[list[Decision], list[Job]]:
        """Return the decisions after the last complete round, and the missing runs of the next one."""
        found: dict[str, int] = {}
        before = 0
        for worlds in _rounds(len(self.seeds)):
            undecided = [case for case in self.others if case.variant not in found and case not in self._always]
            active = [*self._always, *undecided]
            missing = [Job(case, seed) for seed in self.seeds[:worlds] for case in active]
            if jobs := [job for job in missing if not is_made(job)]:
                return self._decisions(found, before), jobs
            clear = self._clear({case.variant: found.get(case.variant, worlds) for case in self.others})
            found |= {variant: worlds for variant in sorted(clear) if variant not in found}
            before = worlds
            if len(found) == len(self.others):
                break
        return self._decisions(found, before), []

    def _decisions(self, found: dict[str, int], worlds: int) -> list[Decision]:
        return [self._decision(case, found.get(case.variant, worlds), found) for case in self.others]

    def _decision(self, case: Case, worlds: int, found: Collection[str]) -> Decision:
        differences = self._differences(case.variant, self.seeds[:worlds])
        mean = float(differences.mean()) if differences.size else 0.0
        return Decision(case, worlds, case.variant in found, matters(mean, self._min_share))

    def _clear(self, worlds: dict[str, int]) -> set[str]:
        """Return the variants that are told from the base by their first worlds."""
        p_values = {}
        for variant, number in worlds.items():
            p_values[variant] = anytime_p(self._differences(variant, self.seeds[:number]))
        judged = zip(p_values, holm(list(p_values.values()), len(p_values)), strict=True)
        return {variant for variant, found in judged if found.is_significant}

    def _differences(self, variant: str, seeds: Sequence[int]) -> Doubles:
        own = self._values[variant]
        return paired_differences({seed: own[seed] for seed in seeds if seed in own}, self._values[self.base.variant])


def _is_needed(plan: Plan, case: Case) -> bool:
    """Return whether what decides is relative to the runs of a case."""
    if not plan.metric(plan.metrics[0]).relative_to:
        return False
    return case.folder == plan.case(case.graph, plan.reference).folder


def _rounds(n_worlds: int) -> Iterator[int]:
    """Yield the number of worlds after each round."""
    yield from range(ROUND, n_worlds, ROUND)
    yield n_worlds


def _values(plan: Plan, case: Case, records: Sequence[Record]) -> Values:
    """Return the deciding metric of a case by seed, from 0 to 1; raises GraphnavError outside of its bounds."""
    runs = (record for record in records if (record.graph, record.variant) == (case.graph, case.variant))
    values = values_of(plan, MetricExpression.parse(plan.metrics[0]), runs)
    return scaled_values(plan, plan.metrics[0], case.graph, case.variant, values)


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
