"""The files of a tuning: what was asked for, what was tried, the tuned rivals as a study, a table."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from graphnav import Graph, UserError
from graphnav.core.graph import Override, beside, find_graph, has_path, resolve_paths, shipped_graphs
from graphnav.core.machine import read_json, write_atomically
from graphnav.core.spec import write_value
from graphnav.core.stage import params_of
from graphnav.core.tables import Table
from graphnav.studies.tuning.rivals import Rival, graphs_of
from graphnav.studies.tuning.tuned_table import table_markdown, trials_text, worlds_text
from graphnav.studies.tuning.tuning import Tuning, overrides_of
from graphnav.studies.tuning.tuning_run import TuningRun

STUDY = "tuned.yaml"


def tuned_study(run: TuningRun, folder: Path) -> str:
    """Return a study in ``folder`` that compares every rival as it is and tuned."""
    tuning = run.tuning
    study = tuning.study
    lines = [
        f"about: {write_value('Which rival is better, as it is and tuned?')}",
        "",
        f"# Tuned in the worlds {worlds_text(tuning)}, with {trials_text(run)}: judge them in others,",
        f"# {_command(run, folder)}",
        "",
        f"graphs: {write_value([_seen_from(folder, name) for name in study.graphs])}",
    ]
    if study.worlds:
        lines.append(f"worlds: {write_value({_seen_from(folder, name): n for name, n in study.worlds.items()})}")
    if study.overrides:
        lines.append(f"set: {write_value(_written(study.overrides, tuning.checked.graphs.values(), folder))}")
    lines += ["", "vary:", "  tuning:"]
    lines += [f"    {write_value(label)}: {write_value(sets)}" for label, sets in _choices(run, folder)]
    lines += ["", f"metrics: {write_value(list(tuning.metrics))}", ""]
    return "\n".join(lines)


def _command(run: TuningRun, folder: Path) -> str:
    """Return the command that judges the rivals, given in ``folder``."""
    plugins = (os.path.relpath(Path(path).resolve(), folder.resolve()) for path in run.tuning.request.plugins)
    words = [word for path in plugins for word in ("--plugin", path)]
    return shlex.join(["graphnav", "ablate", STUDY, *words, "--seeds", "1000:1050"])


def _choices(run: TuningRun, folder: Path) -> Iterator[tuple[str, Mapping[str, Any]]]:
    for rival in run.tuning.rivals:
        best, graphs = run.best(rival), graphs_of(run.tuning.checked, rival.label)
        own = _written(rival.overrides, graphs, folder)
        yield f"{rival.label} as it is", own
        if best.params:
            yield tuned_label(rival), own | _written(overrides_of(best), graphs, folder)


def tuned_label(rival: Rival) -> str:
    """Return the label of a tuned rival."""
    return f"{rival.label} tuned"


def _written(overrides: Iterable[Override], graphs: Iterable[Graph], folder: Path) -> dict[str, Any]:
    """Return the values of overrides by target, paths as they are found from ``folder``."""
    nodes = [node for graph in graphs for node in graph.nodes]
    values = {}
    for override in overrides:
        target, value = override.target, override.value
        if target.kind == "setting":
            declared = (params_of(node.stage_class).get(target.key) for node in nodes if node.name in target.stages)
            param = next((one for one in declared if one is not None and has_path(one.type)), None)
            if param is not None:
                value = value if override.folder is None else beside(value, override.folder)
                value = _relative(value, resolve_paths(param.type, param.parse(value), Path.cwd()).anywhere, folder)
        values[str(target)] = value
    return values


def _relative(value: Any, found: Any, folder: Path) -> Any:
    """Return a value with the path from ``folder`` to what was found; what names no file, or ships, as it is."""
    if isinstance(value, list):
        return [_relative(item, of, folder) for item, of in zip(value, found, strict=True)]
    if not (isinstance(found, Path) and found.is_absolute()):
        return value
    relative = os.path.relpath(found.resolve(), folder.resolve())
    return relative if beside(relative, folder) != relative else str(found)


def _seen_from(folder: Path, graph: str) -> str:
    """Return the path of a graph from a folder; the name of one that ships as it is."""
    path = find_graph(graph)
    return graph if path == shipped_graphs().get(graph) else os.path.relpath(path.resolve(), folder.resolve())


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
    trials = _trials(run).csv_text()
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


def _trials(run: TuningRun) -> Table:
    """Return a row for every trial and world, a column for every parameter and metric."""
    metrics = list(run.tuning.metrics)
    targets = list(dict.fromkeys(one.target for rival in run.tuning.rivals for one in rival.space))
    rows = []
    for rival in run.tuning.rivals:
        for trial in run.of(rival):
            params = rival.center if not trial.params else trial.params
            shown = [write_value(params[target]) if target in params else None for target in targets]
            for graph, seed in run.tuning.worlds:
                values = [trial.values[metric].get((graph, seed)) for metric in metrics]
                failed = trial.failures.get((graph, seed))
                rows.append([rival.label, trial.number, trial.refused, graph, seed, failed, *values, *shown])
    return Table.plain(["rival", "trial", "refused", "graph", "seed", "failed", *metrics, *targets], rows)
