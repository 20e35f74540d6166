"""The result of a tuning in Markdown, and as rows for the terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from graphnav.ablation.study import listed
from graphnav.spec import write_value
from graphnav.tuning.rivals import Rival
from graphnav.tuning.trial import Trial
from graphnav.tuning.tuning_run import TuningRun

OPTIMISTIC = (
    "These are the worlds that the parameters were chosen in, so the tuned values are too good: judge them in worlds "
    "that nothing was tuned in."
)


def header(run: TuningRun) -> list[str]:
    """Return the columns of the table."""
    metrics = [column for metric in run.tuning.metrics for column in (metric, "tuned")]
    return ["rival", "trials", *metrics, "best trial", "parameters"]


def rows(run: TuningRun) -> Iterator[list[str]]:
    """Yield the rivals, the best one after tuning first."""
    for rival in run.ranking(tuned=True):
        default, best = run.default(rival), run.best(rival)
        values = [_mean(run, trial, metric) for metric in run.tuning.metrics for trial in (default, best)]
        yield [rival.label, str(len(run.of(rival))), *values, str(best.number), _params(best)]


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


def table_markdown(run: TuningRun) -> str:
    """Return the table, what it says, and what was searched."""
    request, study = run.tuning.request, run.tuning.study
    names = header(run)
    lines = [_line(names), _line(["---"] * len(names)), *map(_line, rows(run))]
    seeds = f"{len(study.seeds)} worlds, seeds {', '.join(map(str, study.seeds))}"
    parts = [
        f"# {study.name}",
        f"{request.trials} trials of each rival on {', '.join(study.graphs)}; {seeds}.",
        "\n".join(lines),
        conclusion(run),
        *(["\n".join(f"- {text}" for text in troubles)] if (troubles := list(trouble_texts(run))) else []),
        OPTIMISTIC,
        "## What was searched",
        "\n".join(line for rival in run.tuning.rivals for line in _searched(rival)),
        f"Repeat it: `{run.tuning.command}`",
    ]
    return "\n\n".join(parts) + "\n"


def _searched(rival: Rival) -> Iterator[str]:
    found = ", ".join(f"`{one.text}`" for one in rival.space) or "nothing"
    yield f"- {rival.label}: {found}"
    if rival.left:
        yield f"  Not searched, because nothing says what they could be: {', '.join(rival.left)}."


def _params(trial: Trial) -> str:
    return ", ".join(f"{name}={write_value(value)}" for name, value in trial.params.items()) or "as it is"


def _mean(run: TuningRun, trial: Trial, metric: str) -> str:
    mean, n_runs = trial.mean(metric), trial.n_runs(metric)
    if mean is None:
        return "undefined"
    return f"{mean:.4g}" if n_runs == run.tuning.runs_per_trial else f"{mean:.4g} (n {n_runs})"


def _line(cells: Sequence[str]) -> str:
    escaped = (cell.replace("|", "\\|").replace("*", "\\*") for cell in cells)
    return f"| {' | '.join(escaped)} |"


def _rank(equal: Sequence[Rival]) -> str:
    labels = listed(rival.label for rival in equal)
    return f"{labels} (equal)" if len(equal) > 1 else labels
