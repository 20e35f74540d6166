"""A tuning as it is asked for, from Python or on the command line."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from graphnav.core.errors import Place, Problem, UserError
from graphnav.core.graph import Override
from graphnav.studies.ablation.study import Study, Vary, seeds_words, study_of_command
from graphnav.studies.tuning.search_range import SearchRange

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
