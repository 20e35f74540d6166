"""The result of a tuning: its table, its sentences, and both in Markdown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from graphnav.core.spec import write_value
from graphnav.core.tables import Table, escaped
from graphnav.studies.ablation.report import bullets, code, document
from graphnav.studies.ablation.study import listed
from graphnav.studies.tuning.rivals import Rival
from graphnav.studies.tuning.trial import Trial
from graphnav.studies.tuning.tuning import Tuning
from graphnav.studies.tuning.tuning_run import TuningRun

OPTIMISTIC = (
    "These are the worlds that the parameters were chosen in, so the tuned values are too good: judge them in worlds "
    "that nothing was tuned in."
)


def tuned_table(run: TuningRun, *, has_params: bool = True) -> Table:
    """Return the rivals, the best one after tuning first; ``has_params``: with the parameters of the best trial."""
    metrics = [column for metric in run.tuning.metrics for column in (metric, "tuned")]
    header = ["rival", "trials", *metrics, "best trial", *(["parameters"] if has_params else [])]
    rows = []
    for rival in run.ranking(tuned=True):
        default, best = run.default(rival), run.best(rival)
        values = [_mean(run, trial, metric) for metric in run.tuning.metrics for trial in (default, best)]
        params = [params_text(best)] if has_params else []
        rows.append([rival.label, str(len(run.of(rival))), *values, str(best.number), *params])
    return Table.plain(header, rows)


def params_text(trial: Trial) -> str:
    """Return the parameters of a trial in one line."""
    return ", ".join(f"{name}={write_value(value)}" for name, value in trial.params.items()) or "as it is"


def conclusion(run: TuningRun) -> str:
    """Return whether tuning moves the ranking."""
    if run.has_failed():
        return f"Every run failed or lacks {next(iter(run.tuning.metrics))}: nothing was tuned."
    before, after = (", then ".join(map(_rank, run.ranks(tuned=tuned))) for tuned in (False, True))
    if before == after:
        return f"Tuning moves no rank: {after}."
    return f"Tuning moves the ranking: as they are {before}; tuned {after}."


def trouble_texts(run: TuningRun) -> Iterator[str]:
    """Yield how many trials of each rival were refused and how many of its runs failed, with the cause of the most."""
    for rival in run.tuning.rivals:
        trials = run.of(rival)
        refused = Counter(trial.refused for trial in trials if trial.refused)
        failed = Counter(cause for trial in trials for cause in trial.failures.values())
        n_runs = len(trials) * run.tuning.runs_per_trial
        for causes, of in ((refused, f"{len(trials)} trials were refused"), (failed, f"{n_runs} runs failed")):
            if causes:
                [(cause, times)] = causes.most_common(1)
                share = f"{times} of them: " if times < causes.total() else ""
                yield f"{rival.label}: {causes.total()} of {of}: {share}{cause}"


def trials_text(run: TuningRun) -> str:
    """Return how many trials were made of each rival; a rival with nothing to search has one."""
    numbers = {len(run.of(rival)) for rival in run.tuning.rivals}
    n_trials = max(numbers)
    return f"{'up to ' if len(numbers) > 1 else ''}{n_trials} trial{'s' if n_trials > 1 else ''} of each rival"


def worlds_text(tuning: Tuning) -> str:
    """Return the seeds of the worlds that trials are made in; those of each graph where they differ."""
    of_graph: dict[str, list[str]] = {}
    for graph, seed in tuning.worlds:
        of_graph.setdefault(graph, []).append(str(seed))
    texts = {graph: ", ".join(seeds) for graph, seeds in of_graph.items()}
    if len(set(texts.values())) == 1:
        return next(iter(texts.values()))
    return "; ".join(f"{seeds} of {graph}" for graph, seeds in texts.items())


def table_markdown(run: TuningRun) -> str:
    """Return the table, what it says, and what was searched."""
    study = run.tuning.study
    parts = [
        f"# {escaped(study.name)}",
        escaped(f"With {trials_text(run)} on {', '.join(study.graphs)}, in the worlds {worlds_text(run.tuning)}."),
        tuned_table(run).markdown(),
        escaped(conclusion(run)),
        *([bullets(map(escaped, troubles))] if (troubles := list(trouble_texts(run))) else []),
        OPTIMISTIC,
        "## What was searched",
        "\n".join(line for rival in run.tuning.rivals for line in _searched(rival)),
        f"Repeat it: {code(run.tuning.command)}",
    ]
    return document(parts)


def _searched(rival: Rival) -> Iterator[str]:
    found = ", ".join(code(one.text) for one in rival.space) or "nothing"
    yield f"- {escaped(rival.label)}: {found}"
    if rival.left:
        yield f"  Not searched, because nothing says what they could be: {', '.join(rival.left)}."


def _mean(run: TuningRun, trial: Trial, metric: str) -> str:
    mean, n_runs = trial.mean(metric), trial.n_runs(metric)
    if mean is None:
        return "undefined"
    return f"{mean:.4g}" if n_runs == run.tuning.runs_per_trial else f"{mean:.4g} (n {n_runs})"


def _rank(equal: Sequence[Rival]) -> str:
    labels = listed(rival.label for rival in equal)
    return f"{labels} (equal)" if len(equal) > 1 else labels
