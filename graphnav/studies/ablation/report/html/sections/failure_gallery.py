"""The worst failures: the last picture of each, by cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from graphnav.studies.ablation.report.html.embedded_picture import embedded_picture
from graphnav.studies.ablation.report.html.number_text import counted
from graphnav.studies.ablation.report.html.render import rendered
from graphnav.studies.ablation.report.html.study_results import StudyResults
from graphnav.studies.ablation.report.html.variant_style import badge_of
from graphnav.studies.ablation.results import Record, failure_folder, is_failure
from graphnav.studies.ablation.worker import ENDING

_CAUSES = {"contact": "Contact", "timeout": "Time was up", "failed": "The run broke down"}
_MAX_PICTURES = 24
_MAX_PX = 1180


@dataclass(frozen=True)
class _Failure:
    """A failed run with its picture."""

    run: Record
    badge: str
    picture: Markup


def gallery(study: StudyResults) -> Markup:
    """Return the pictures that the folder has of failures, the methods' first, few of each variant."""
    failures = _failures(study)
    found = [(run, file) for run in failures if (file := _picture(study, run)) is not None]
    kept = _spread(study, found)
    causes = [
        (title, [_failure(study, run, file) for run, file in kept if run.outcome == cause])
        for cause, title in _CAUSES.items()
    ]
    n = len(failures)
    return rendered(
        "failures.html",
        causes=[(title, of) for title, of in causes if of],
        missing=f"{counted(n, 'run')} failed; none is drawn." if n else "No run ended in a failure.",
        n_shown=len(kept),
        n_failures=counted(n, "failure"),
    )


def _failures(study: StudyResults) -> list[Record]:
    own = {(case.graph, case.variant) for case in study.plan.cases if not case.same_as}
    return [run for run in study.records if is_failure(study.plan, run) and (run.graph, run.variant) in own]


def _picture(study: StudyResults, run: Record) -> Path | None:
    place = study.folder / failure_folder(study.plan.case(run.graph, run.variant), run.seed)
    pictures = sorted(place.glob("*.png"), key=lambda file: (file.name != ENDING, file.name))
    return pictures[0] if pictures else None


def _spread(study: StudyResults, found: Sequence[tuple[Record, Path]]) -> list[tuple[Record, Path]]:
    """Return at most so many: round by round one of each case, methods before baselines, the soonest ended first."""
    special = {(case.graph, case.variant) for case in study.plan.cases if case.role != "method"}
    turns: dict[tuple[str, str], int] = {}
    ranked = []
    for run, file in sorted(found, key=lambda pair: (pair[0].sim_s, pair[0].seed)):
        case = (run.graph, run.variant)
        turns[case] = turns.get(case, 0) + 1
        ranked.append((case in special, turns[case], run, file))
    ranked.sort(key=lambda entry: entry[:2])
    return [(run, file) for _, _, run, file in ranked[:_MAX_PICTURES]]


def _failure(study: StudyResults, run: Record, file: Path) -> _Failure:
    about = f"{run.variant} on {run.graph}, seed {run.seed}: {run.outcome}"
    badge = badge_of(study.plan.case(run.graph, run.variant))
    return _Failure(run, badge, embedded_picture(file, about, _MAX_PX))
