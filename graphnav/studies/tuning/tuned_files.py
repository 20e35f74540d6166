"""The files of a tuning: what was asked for, what was tried, the tuned rivals as a study, a table."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

from graphnav.core.errors import UserError
from graphnav.core.machine.regular_file import read_json
from graphnav.core.spec import write_value
from graphnav.studies.ablation.report import write_atomically
from graphnav.studies.tuning.tuned_study import STUDY, tuned_study
from graphnav.studies.tuning.tuned_table import table_markdown
from graphnav.studies.tuning.tuning import Tuning
from graphnav.studies.tuning.tuning_run import TuningRun

TUNING = "tuning.json"
TRIALS = "trials.csv"
TABLE = "tuned.md"
_N_TRIALS = "trials"
_ELSEWHERE = "choose another folder with -o"


def begin_tuning(tuning: Tuning, folder: Path) -> None:
    """Write what is asked for into the folder of a tuning; more trials of the same continue one that was begun.

    Raises
    ------
    UserError
        The folder cannot be written, or holds another tuning, or more trials.
    """
    path, n_trials = folder / TUNING, tuning.request.trials
    settings = json.loads(json.dumps(tuning.settings()))
    try:
        begun = read_json(path) if path.exists() else settings | {_N_TRIALS: 0}
        n_begun = int(begun.get(_N_TRIALS, 0))
    except OSError as error:
        raise UserError.of(f"cannot work in {folder}: {error.strerror}", _ELSEWHERE) from error
    except (ValueError, TypeError, AttributeError) as error:
        raise UserError.of(f"{path} is not the record of a tuning", _ELSEWHERE) from error
    for key, value in settings.items():
        if begun.get(key) != value:
            raise UserError.of(f"{folder} holds another tuning: its '{key}' differs", _ELSEWHERE)
    if n_trials < n_begun:
        what = (
            f"{folder} holds a tuning that was begun with {n_begun} trials of each rival, and this asks for {n_trials}"
        )
        raise UserError.of(what, f"continue it with {n_begun} trials or more, or {_ELSEWHERE}")
    write_atomically(path, json.dumps(settings | {_N_TRIALS: n_trials}, indent=1) + "\n")


def write_tuning(run: TuningRun, folder: Path) -> None:
    """Write the trials, the study of the tuned rivals and the table, unless the files there are of more trials.

    Raises
    ------
    GraphnavError
        A file cannot be written; its old version is kept.
    """
    trials = _trials(run)
    if _n_lines(folder / TRIALS) > trials.count("\n"):
        return
    write_atomically(folder / TRIALS, trials)
    write_atomically(folder / STUDY, tuned_study(run, folder))
    write_atomically(folder / TABLE, table_markdown(run))


def _n_lines(path: Path) -> int:
    try:
        return path.read_bytes().count(b"\n")
    except OSError:  # there is none, or writing it reports why
        return 0


def _trials(run: TuningRun) -> str:
    """Return a line for every trial and world, a column for every parameter and metric."""
    metrics = list(run.tuning.metrics)
    targets = list(dict.fromkeys(one.target for rival in run.tuning.rivals for one in rival.space))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["rival", "trial", "refused", "graph", "seed", "failed", *metrics, *targets])
    for rival in run.tuning.rivals:
        for trial in run.of(rival):
            params = rival.center if not trial.params else trial.params
            shown = [write_value(params[target]) if target in params else "" for target in targets]
            for graph, seed in run.tuning.worlds:
                found = [trial.values[metric].get((graph, seed)) for metric in metrics]
                values = ["" if value is None else repr(value) for value in found]
                failed = trial.failures.get((graph, seed), "")
                writer.writerow([rival.label, trial.number, trial.refused, graph, seed, failed, *values, *shown])
    return text.getvalue()
