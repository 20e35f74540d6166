"""The files of a tuning: what was asked for, what was tried, the tuned rivals as a study, a table."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from graphnav.ablation.report import write_atomically
from graphnav.errors import UserError
from graphnav.graph import find_graph, shipped_graphs
from graphnav.spec import write_value
from graphnav.tuning.rivals import Rival
from graphnav.tuning.tuned_table import table_markdown
from graphnav.tuning.tuning import Tuning, overrides_of
from graphnav.tuning.tuning_run import TuningRun

TUNING = "tuning.json"
TRIALS = "trials.csv"
STUDY = "tuned.yaml"
TABLE = "tuned.md"


def check_folder(tuning: Tuning, folder: Path) -> None:
    """Write what is asked for into a new folder, or compare it with what a folder began with.

    Raises
    ------
    UserError
        It cannot be made, holds something else, or another tuning.
    """
    path, settings = folder / TUNING, tuning.settings()
    hint = "choose another folder with -o"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            if others := sorted(one.name for one in folder.iterdir()):
                raise UserError.of(f"{folder} holds {others[0]}, but no tuning ({TUNING})", hint)
            write_atomically(path, json.dumps(settings, indent=1) + "\n")
            return
        old = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError.of(f"cannot work in {folder}: {error.strerror}", hint) from error
    except ValueError as error:
        raise UserError.of(f"{path} is not the record of a tuning", hint) from error
    if not isinstance(old, dict):
        raise UserError.of(f"{path} is not the record of a tuning", hint)
    for key, value in json.loads(json.dumps(settings)).items():
        if old.get(key) != value:
            raise UserError.of(f"{folder} holds another tuning: its '{key}' differs", hint)


def write_tuning(run: TuningRun, folder: Path) -> None:
    """Write the trials, the study of the tuned rivals and the table.

    Raises
    ------
    GraphnavError
        A file cannot be written; its old version is kept.
    """
    write_atomically(folder / TRIALS, _trials(run))
    write_atomically(folder / STUDY, _study(run, folder))
    write_atomically(folder / TABLE, table_markdown(run))


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


def _study(run: TuningRun, folder: Path) -> str:
    """Return a study in ``folder`` that compares every rival as it is and tuned."""
    study = run.tuning.study
    seeds = ", ".join(map(str, study.seeds))
    lines = [
        f"about: {write_value('Which rival is better, as it is and tuned?')}",
        "",
        f"# Tuned in the worlds {seeds}, with {run.tuning.request.trials} trials of each rival: judge them in others,",
        f"# graphnav ablate {STUDY} --seeds 1000:1050",
        "",
        f"graphs: {write_value([_seen_from(folder, name) for name in study.graphs])}",
    ]
    if study.overrides:
        lines.append(f"set: {write_value({str(one.target): one.value for one in study.overrides})}")
    lines += ["", "vary:", "  tuning:"]
    lines += [f"    {write_value(label)}: {write_value(sets)}" for label, sets in _choices(run)]
    lines += ["", f"metrics: {write_value(list(run.tuning.metrics))}", ""]
    return "\n".join(lines)


def _seen_from(folder: Path, graph: str) -> str:
    """Return the path of a graph from a folder; the name of one that ships as it is."""
    path = find_graph(graph)
    return graph if path == shipped_graphs().get(graph) else os.path.relpath(path.resolve(), folder.resolve())


def _choices(run: TuningRun) -> Iterator[tuple[str, Mapping[str, Any]]]:
    for rival in run.tuning.rivals:
        best = run.best(rival)
        own = {str(override.target): override.value for override in rival.overrides}
        yield f"{rival.label} as it is", own
        if best.params:
            yield tuned_label(rival), own | {str(one.target): one.value for one in overrides_of(best)}


def tuned_label(rival: Rival) -> str:
    """Return the label of a tuned rival."""
    return f"{rival.label} tuned"
