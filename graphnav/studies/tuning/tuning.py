"""A tuning: as it is asked for, checked, and its rivals."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from graphnav import Place, Problem, UserError
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override, Target
from graphnav.core.machine import install_command
from graphnav.core.stage import Better
from graphnav.studies.ablation.plan import CheckedStudy, check_study, with_versions
from graphnav.studies.ablation.study import Axis, Choice, Study, Vary, seeds_words, study_of_command
from graphnav.studies.tuning.rivals import Rival, rivals_of
from graphnav.studies.tuning.search_range import SearchRange
from graphnav.studies.tuning.trial import Trial

FIRST_REPORTED_SEED = 1000
"""Worlds from this seed on are reported on: what was tuned in them would be judged by what it was made for."""
_AXIS = "name the rivals: --vary plane=plane.ica,plane.homography"


@dataclass(frozen=True, kw_only=True)
class TuningRequest:
    """Rivals on graphs, or those of a study with one axis, and the budget of each."""

    names: Sequence[str]
    varies: Sequence[Vary]
    overrides: Sequence[Override]
    seeds: str | Sequence[int] | None
    """As ``--seeds`` takes them, or integers; None: those of the study."""
    metrics: Sequence[str]
    """The metrics to tune for, the one that decides first; equal trials are told apart by the next."""
    searches: Sequence[SearchRange]
    """Ranges in place of those that follow from the parameters' declarations."""
    trials: int
    """Of each rival, the first of which changes nothing."""
    sampler_seed: int
    plugins: Sequence[Path]
    problems: Sequence[Problem] = ()
    """Problems of options that were parsed before."""

    @property
    def command(self) -> str:
        """The command line that asks for the same."""
        options: tuple[tuple[str, Sequence[object]], ...] = (
            ("--vary", [vary.words for vary in self.varies]),
            ("--set", [override.words for override in self.overrides]),
            ("--metrics", self.metrics),
            ("--search", [search.text for search in self.searches]),
            ("--plugin", self.plugins),
            ("--seeds", [] if self.seeds is None else [seeds_words(self.seeds)]),
        )
        words = [word for option, values in options for value in values for word in (option, str(value))]
        budget = ["--trials", str(self.trials), "--sampler-seed", str(self.sampler_seed)]
        return shlex.join(["graphnav", "tune", *self.names, *words, *budget])

    def study(self) -> Study:
        """Return the study of the rivals as they are.

        Raises
        ------
        UserError
            What is wrong with the names and options, or what a tuning cannot be made of.
        """
        study = study_of_command(
            self.names,
            varies=self.varies,
            overrides=self.overrides,
            metrics=self.metrics,
            seeds=self.seeds,
            problems=self.problems,
        )
        if problems := list(_problems(study)):
            raise UserError(problems)
        return study


def _problems(study: Study) -> list[Problem]:
    found = []
    if len(study.axes) != 1:
        names = ", ".join(axis.name for axis in study.axes)
        hint = "keep one axis, whose choices are the rivals; --set sets the others"
        found.append(Problem(None, f"the study varies {len(study.axes)} axes: {names}", hint))
    elif study.within:
        found.append(Problem(None, "the axis of the study is a condition, and has no rivals", _AXIS))
    if study.reference:
        hint = "remove it, and tune for a metric of each drive, as drive.spl"
        found.append(Problem(study.places.get(study.reference), "a tuning has no runs of a reference", hint))
    if not study.metrics:
        hint = "name it, then what tells equal trials apart: --metrics drive.success,drive.spl"
        found.append(Problem(None, "no metric to tune for is named", hint))
    if not study.seeds:
        found.append(Problem(None, "no worlds to tune in are named", "name seeds below 1000: --seeds 0:8"))
    if late := [seed for seed in study.seeds if seed >= FIRST_REPORTED_SEED]:
        what = f"seed {late[0]} is for reporting: what is tuned in a world cannot be judged in it"
        found.append(Problem(Place("--seeds"), what, f"name seeds below {FIRST_REPORTED_SEED}: --seeds 0:8"))
    return found


_SAMPLER = "optuna"


@dataclass(frozen=True)
class Tuning:
    """Rivals that can be tuned."""

    request: TuningRequest
    study: Study
    checked: CheckedStudy
    """The rivals as they are."""
    rivals: tuple[Rival, ...]
    catalog: Catalog
    command: str

    @property
    def metrics(self) -> Mapping[str, Better]:
        """The metrics to tune for, and which values are better."""
        return {metric: self.checked.plan.better(metric) for metric in self.checked.plan.metrics}

    @property
    def n_runs(self) -> int:
        """The number of runs."""
        return sum(self.n_trials(rival) for rival in self.rivals) * self.runs_per_trial

    @property
    def worlds(self) -> tuple[tuple[str, int], ...]:
        """Graph and seed of every run of a trial."""
        plan = self.checked.plan
        return tuple((case.graph, seed) for case in plan.cases if case.is_base for seed in plan.seeds_of(case))

    @property
    def runs_per_trial(self) -> int:
        """The number of runs of each trial."""
        return len(self.worlds)

    def n_trials(self, rival: Rival) -> int:
        """Return the number of trials of a rival: one where nothing of it is searched."""
        return self.request.trials if rival.space else 1

    def settings(self) -> dict[str, Any]:
        """Return all that decides what is tried; the number of trials may grow."""
        plan = self.checked.plan
        return {
            "graphs": list(plan.graphs),
            "rivals": {rival.label: [override.words for override in rival.overrides] for rival in self.rivals},
            "search": {rival.label: [searched.text for searched in rival.space] for rival in self.rivals},
            "set": [override.words for override in self.study.overrides],
            "seeds": list(self.study.seeds),
            "worlds": Counter(graph for graph, _ in self.worlds),
            "metrics": list(plan.metrics),
            "sampler": f"TPE of {_SAMPLER} {version(_SAMPLER)}, seed {self.request.sampler_seed}",
            "versions": dict(plan.versions),
        }

    def batch(self, trials: Sequence[Trial]) -> tuple[CheckedStudy | None, dict[str, str]]:
        """Return the study of trials, None if there is none to run, and why parameters are refused, by label."""
        refused: dict[str, str] = {}
        choices = {label_of(trial): self._choice(trial) for trial in trials}
        try:
            return self._checked(choices.values()), refused
        except UserError:
            for label, choice in choices.items():
                try:
                    self._checked([choice])
                except UserError as error:
                    refused[label] = error.problems[0].what
        fine = [choice for label, choice in choices.items() if label not in refused]
        return self._checked(fine) if fine else None, refused

    def _checked(self, choices: Any) -> CheckedStudy:
        [axis] = self.study.axes
        study = replace(self.study, axes=(Axis(axis.name, tuple(choices), axis.place),))
        return with_versions(check_study(study, self.catalog, self.command, self.request.plugins))

    def _choice(self, trial: Trial) -> Choice:
        rival = next(rival for rival in self.rivals if rival.label == trial.rival)
        return Choice(label_of(trial), (*rival.overrides, *overrides_of(trial)))


def overrides_of(trial: Trial) -> tuple[Override, ...]:
    """Return what a trial sets."""
    place = Place(label_of(trial))
    return tuple(Override(Target.parse(name, place), value, place) for name, value in trial.params.items())


def label_of(trial: Trial) -> str:
    """Return the label of a trial in its batch."""
    return f"{trial.rival} trial {trial.number}"


def optuna_missing(who: str) -> UserError | None:
    """Return the error of a missing Optuna, None where it is installed."""
    try:
        version(_SAMPLER)
    except PackageNotFoundError:
        return UserError.of(f"{who} needs Optuna", install_command("tune"))
    return None


def check_tuning(request: TuningRequest, catalog: Catalog, command: str) -> Tuning:
    """Check the graphs of all rivals, and find what is searched.

    Raises
    ------
    UserError
        Everything that is wrong with the request and its graphs, or Optuna is not installed.
    """
    if missing := optuna_missing("graphnav tune"):
        raise missing
    study = request.study()
    checked = with_versions(check_study(study, catalog, command, request.plugins))
    rivals = rivals_of(study, checked, request.searches)
    if not any(rival.space for rival in rivals):
        hint = "name ranges: --search plane.threshold_px=0.05:2"
        raise UserError.of("the rivals have no parameter that could be searched", hint)
    return Tuning(request, study, checked, rivals, catalog, command)


def named_after(names: Sequence[str]) -> str:
    """Return the name of a tuning's folder."""
    return "_".join(Path(name).stem for name in names)[:60]
