"""Check the metrics of a study against the stages that declare them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from graphnav.core.errors import Place, Problem, UserError, did_you_mean
from graphnav.core.stage import Metric, Stage, former_names, metrics_of
from graphnav.studies.ablation.study import MetricExpression, Study

Classes = Mapping[str, Sequence[type[Stage]]]
"""The classes of the stages of all cases, by their names in the graphs."""


def checked_metrics(study: Study, classes: Classes, problems: list[Problem]) -> tuple[str, ...]:
    """Return the columns of a study's table; what is wrong is added to ``problems``."""
    columns: list[str] = []
    for text in study.metrics:
        place = study.places.get(text)
        try:
            column = MetricExpression.parse(text)
        except UserError as error:
            problems += [Problem(place, problem.what, problem.hint) for problem in error.problems]
            continue
        wrong = [*_unknown(column, place, classes), *_without_reference(study, column, place, classes)]
        problems += wrong
        if not wrong:
            columns.append(column.text)
    return tuple(dict.fromkeys(columns))


def declared_metrics(classes: Classes) -> dict[str, Metric]:
    """Return the declared metrics by ``stage.metric``; of a stage that is swapped, the first class counts."""
    found: dict[str, Metric] = {}
    for stage, each in classes.items():
        for cls in each:
            for name, metric in metrics_of(cls).items():
                found.setdefault(f"{stage}.{name}", metric)
    return found


def _without_reference(
    study: Study, column: MetricExpression, place: Place | None, classes: Classes
) -> Iterator[Problem]:
    declared = declared_metrics(classes)
    for operand in column.operands:
        metric = declared.get(operand)
        if metric is not None and metric.relative_to and not study.reference:
            what = f"'{operand}' is relative to a reference variant, and the study names none"
            yield Problem(place, what, "write reference: VARIANT, or --reference VARIANT")


def _unknown(column: MetricExpression, place: Place | None, classes: Classes) -> Iterator[Problem]:
    declared = declared_metrics(classes)
    scored = [name for name, found in classes.items() if any(metrics_of(cls) for cls in found)]
    stages = f"stages that report metrics are {', '.join(scored)}" if scored else "no stage reports any: add a score"
    for operand in column.operands:
        stage, _, metric = operand.partition(".")
        if stage not in classes:
            yield Problem(place, f"'{operand}': no graph has a stage '{stage}'", did_you_mean(stage, scored) or stages)
        elif stage not in scored:
            yield Problem(place, f"'{operand}': stage '{stage}' reports no metrics", stages)
        elif operand not in declared:
            known = [name for cls in classes[stage] for name in metrics_of(cls)]
            near = did_you_mean(metric, known, {**former_names.METRICS, **former_names.REPLACED_METRICS})
            hint = near or f"its metrics are {', '.join(dict.fromkeys(known))}"
            yield Problem(place, f"'{operand}': stage '{stage}' has no metric '{metric}'", hint)
