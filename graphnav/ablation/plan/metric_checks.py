"""Check the metrics of a study against the stages that compute them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from graphnav.ablation.plan.plan import Better
from graphnav.ablation.study import MetricExpression, Study
from graphnav.errors import Place, Problem, UserError, did_you_mean
from graphnav.stage import Stage

Classes = Mapping[str, Sequence[type[Stage]]]
"""The classes of the stages of all cases, by their names in the graphs."""


def checked_metrics(study: Study, classes: Classes, problems: list[Problem]) -> dict[str, Better]:
    """Return the columns of a study's table and which values are better; what is wrong is added to ``problems``.

    Whether a stage says a metric of that name is known only after a run.
    """
    metrics: dict[str, Better] = {}
    for text in study.metrics:
        place = study.places.get(text)
        try:
            metric = MetricExpression.parse(text)
        except UserError as error:
            problems += [Problem(place, problem.what, problem.hint) for problem in error.problems]
            continue
        wrong = list(_unknown(metric, place, classes))
        problems += wrong
        if not wrong:
            metrics[metric.text] = "less" if metric.operands[0] in less_is_better(classes) else "more"
    return metrics


def less_is_better(classes: Classes) -> tuple[str, ...]:
    """Return every ``stage.metric`` of which less is better."""
    found = ((name, metric) for name, each in classes.items() for cls in each for metric in sorted(cls.less_is_better))
    return tuple(dict.fromkeys(f"{name}.{metric}" for name, metric in found))


def _unknown(metric: MetricExpression, place: Place | None, classes: Classes) -> Iterator[Problem]:
    scored = [name for name, found in classes.items() if any(cls.summary is not Stage.summary for cls in found)]
    known = f"stages that say figures are {', '.join(scored)}" if scored else "no stage says any: add a score"
    for operand in metric.operands:
        stage = operand.partition(".")[0]
        if stage not in classes:
            yield Problem(place, f"'{operand}': no graph has a stage '{stage}'", did_you_mean(stage, scored) or known)
        elif stage not in scored:
            yield Problem(place, f"'{operand}': stage '{stage}' says no figures", known)
