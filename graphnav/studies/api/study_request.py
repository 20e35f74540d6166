"""A study as it is asked for, from Python or on the command line."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from graphnav import Problem
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override
from graphnav.studies.ablation.decompose import decomposed_study
from graphnav.studies.ablation.plan import CheckedStudy, check_study, with_versions
from graphnav.studies.ablation.stopping import check_stopping
from graphnav.studies.ablation.study import Vary, seeds_words, study_of_command


@dataclass(frozen=True, kw_only=True)
class StudyRequest:
    """A study, or graphs, with what changes it; `study_of_command` says what each field means."""

    names: Sequence[str]
    varies: Sequence[Vary]
    overrides: Sequence[Override]
    seeds: str | Sequence[int] | None
    """As ``--seeds`` takes them, or integers; None: those of the study."""
    metrics: Sequence[str]
    within: Sequence[str]
    one_at_a_time: bool
    plugins: Sequence[Path]
    reference: str | None = None
    """None: that of the study."""
    worlds: Mapping[str, int] = field(default_factory=dict)
    decompose: bool = False
    """Whether the stages of the drive are swapped for their oracles (`decomposed_study`)."""
    until_clear: bool = False
    """Whether the results decide how many of the seeds are used."""
    problems: Sequence[Problem] = ()
    """Problems of options that were parsed before."""

    def check(self, catalog: Catalog, command: str = "") -> CheckedStudy:
        """Return the checked study, with the versions that its runs depend on; ``command`` makes it again.

        Raises
        ------
        UserError
            Everything that is wrong with it and its graphs.
        """
        study = study_of_command(
            self.names,
            varies=self.varies,
            overrides=self.overrides,
            metrics=self.metrics,
            within=self.within,
            seeds=self.seeds,
            one_at_a_time=self.one_at_a_time,
            reference=self.reference,
            worlds=self.worlds,
            may_vary_nothing=self.decompose,
            problems=self.problems,
        )
        if self.decompose:
            study = decomposed_study(study, catalog)
        checked = check_study(study, catalog, command or self.command, self.plugins)
        plan = replace(checked.plan, until_clear=self.until_clear)
        if self.until_clear:
            check_stopping(plan)
        return with_versions(replace(checked, plan=plan))

    @property
    def command(self) -> str:
        """The command line that asks for the same."""
        options: tuple[tuple[str, Sequence[object]], ...] = (
            ("--vary", [vary.words for vary in self.varies]),
            ("--set", [override.words for override in self.overrides]),
            ("--metrics", self.metrics),
            ("--within", self.within),
            ("--plugin", self.plugins),
            ("--reference", [] if self.reference is None else [self.reference]),
            ("--worlds", [f"{graph}={number}" for graph, number in self.worlds.items()]),
            ("--seeds", [] if self.seeds is None else [seeds_words(self.seeds)]),
        )
        words = [word for option, values in options for value in values for word in (option, str(value))]
        flags = {
            "--one-at-a-time": self.one_at_a_time,
            "--decompose": self.decompose,
            "--until-clear": self.until_clear,
        }
        words += [flag for flag, is_set in flags.items() if is_set]
        return shlex.join(["graphnav", "ablate", *self.names, *words])
