"""Write the cases of a study to MLflow."""

from __future__ import annotations

import math
import os
import posixpath
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from graphnav import UserError, import_extra
from graphnav.studies.ablation.plan import Case, Plan
from graphnav.studies.ablation.report import RESULTS, TABLE
from graphnav.studies.ablation.results import Row
from graphnav.studies.api.study_files import StudyFiles

SERVER_VARIABLE = "MLFLOW_TRACKING_URI"
"""The environment variable of MLflow that names its server, or a store."""
_FORBIDDEN = re.compile(r"[^\w\-. /]")
"""In names of parameters and metrics."""
_MAX_NAME = 240
"""MLflow takes names of 250 characters."""
_UNKNOWN = "INTERNAL_ERROR"
"""The code of errors of which MLflow tells no cause, as that of a server that does not answer."""
_Value = TypeVar("_Value", str, float)


def export_to_mlflow(plan: Plan, files: StudyFiles, folder: Path) -> str:
    """Write an MLflow run for each case of a study: parameters, means with intervals, tables; return where.

    The experiment is called as the study. Writing it again adds runs; nothing is replaced.

    Raises
    ------
    UserError
        MLflow is not installed, no server is named, or it refuses.
    """
    failure = import_extra("mlflow.exceptions", "mlflow", "--export mlflow", "MLflow").MlflowException
    tracking = import_extra("mlflow.tracking", "mlflow", "--export mlflow", "MLflow")
    uri = os.environ.get(SERVER_VARIABLE, "")
    if not uri:
        hint = f"start one by 'mlflow server', and set {SERVER_VARIABLE}=http://127.0.0.1:5000"
        raise UserError.of("--export mlflow: no MLflow server is named", hint)
    try:
        client = tracking.MlflowClient(uri)
        found = client.get_experiment_by_name(plan.name)
        experiment = found.experiment_id if found else client.create_experiment(plan.name)
        for row in files.comparison.rows:
            if not row.case.same_as:
                _write_case(client, experiment, plan, row, folder)
    except (failure, OSError) as error:
        if getattr(error, "error_code", _UNKNOWN) != _UNKNOWN:
            hint = "change that there, and export again"
            raise UserError.of(f"MLflow at {uri} refuses this study: {error}", hint) from error
        raise UserError.of(f"MLflow at {uri}: {error}", f"set {SERVER_VARIABLE} to a server that answers") from error
    return uri


def _write_case(client: Any, experiment: str, plan: Plan, row: Row, folder: Path) -> None:
    """Write a run; it is marked as failed where it is not complete."""
    run = client.create_run(experiment, run_name=f"{row.case.graph}, {row.case.variant}").info.run_id
    try:
        for name, value in _allowed_names(_params(plan, row.case)).items():
            client.log_param(run, name, value)
        for name, number in _allowed_names(_metrics(row)).items():
            if math.isfinite(number):
                client.log_metric(run, name, number)
        for file in (TABLE, RESULTS):
            client.log_artifact(run, str(folder / file))
    except BaseException:
        with suppress(Exception):
            client.set_terminated(run, "FAILED")
        raise
    client.set_terminated(run)


def _allowed_names(values: Iterable[tuple[str, _Value]]) -> dict[str, _Value]:
    """Return values by names that MLflow takes: other characters are replaced, and no two names are made the same."""
    found: dict[str, _Value] = {}
    for name, value in values:
        allowed = _FORBIDDEN.sub("_", name)[:_MAX_NAME]
        if posixpath.normpath(allowed) != allowed:
            allowed = allowed.replace("/", "_")
        while allowed in found:
            allowed += "_"
        found[allowed] = value
    return found


def _params(plan: Plan, case: Case) -> Iterator[tuple[str, str]]:
    yield from {"graph": case.source, "variant": case.variant, "role": case.role}.items()
    yield "command", plan.command
    yield from ((f"axis.{axis}", label) for axis, label in case.labels.items())
    yield from ((f"use.{stage}", use) for stage, use in case.uses.items())


def _metrics(row: Row) -> Iterator[tuple[str, float]]:
    yield "worlds", float(row.runs)
    for name, found in row.estimates.items():
        yield from ((name, found.mean), (f"{name}.low", found.low), (f"{name}.high", found.high))
    for name, other in row.differences.items():
        yield from ((f"{name}.difference", other.mean), (f"{name}.difference_low", other.low))
        yield f"{name}.difference_high", other.high
