"""Maps with the paths that were driven, and how failures ended."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from graphnav import GraphnavError, Recording
from graphnav.core.errors import DrawingError
from graphnav.core.pictures import DRAWING_FAMILY, drawing
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Outcome
from graphnav.studies.ablation.report.html.rendering import counted, embedded_picture, rendered
from graphnav.studies.ablation.report.html.study_results import StudyResults, badge_of, colours_of
from graphnav.studies.ablation.results import Record, failure_folder, is_failure
from graphnav.studies.ablation.worker import ENDING

FOLDER = "paths"
_FIRST, _DISPUTED, _MANY_GRAPHS = 2, 3, 4
_MAX_PATHS = {"method": 8, "baseline": 3, "oracle": 2}
_MAX_PX = 520


@dataclass(frozen=True)
class _World:
    """The map of a world with the paths through it, or why it cannot be drawn."""

    seed: int
    picture: Markup
    outcomes: str
    error: str = ""


def maps(study: StudyResults) -> Markup:
    """Return maps with paths: of the first worlds and of those in which variants differ most."""
    variants = _variants(study)
    colours = colours_of(study)
    study.catalog.load(DRAWING_FAMILY)
    graphs = []
    for graph in study.plan.graphs:
        own = [variant for variant in variants if not study.plan.case(graph, variant).same_as]
        runs = {v: {run.seed: run for run in study.runs.get((graph, v), ())} for v in own}
        seeds = _worlds(study, graph, variants)
        drawn = [_map(study, graph, seed, [of[seed] for of in runs.values() if seed in of], colours) for seed in seeds]
        if shown := [world for world in drawn if world is not None]:
            graphs.append((graph, shown))
    return rendered(
        "path_maps.html",
        graphs=graphs,
        colours=[(variant, colours[variant]) for variant in variants],
        n_left_out=len(study.own_variants) - len(variants),
    )


def _variants(study: StudyResults) -> Sequence[str]:
    """Return whose paths are drawn: of each role the first few, the base among them."""
    roles = {case.variant: case.role for case in study.plan.cases}
    used = dict.fromkeys(_MAX_PATHS, 0)
    kept = []
    for variant in study.own_variants:
        role = roles[variant]
        used[role] += 1
        if used[role] <= _MAX_PATHS[role]:
            kept.append(variant)
    return kept


def _worlds(study: StudyResults, graph: str, variants: Sequence[str]) -> Sequence[int]:
    """Return the seeds of the worlds to draw, the first ones first."""
    seeds = study.plan.seeds_of(study.own_rows(graph)[0].case)
    first, disputed = (_FIRST, _DISPUTED) if len(study.plan.graphs) <= _MANY_GRAPHS else (1, 2)
    outcomes: dict[int, list[str]] = {}
    for variant in variants:
        if study.plan.case(graph, variant).role == "method":
            for run in study.runs.get((graph, variant), ()):
                outcomes.setdefault(run.seed, []).append(run.outcome)
    doubt = {
        seed: sum(one != Outcome.GOAL for one in of) * sum(one == Outcome.GOAL for one in of)
        for seed, of in outcomes.items()
    }
    begin = list(seeds[:first])
    rest = sorted((s for s in seeds if s not in begin), key=lambda s: (-doubt.get(s, 0), s))
    doubtful = [seed for seed in rest if doubt.get(seed, 0) > 0][:disputed]
    return [*begin, *(doubtful or rest[:disputed])]


def _map(study: StudyResults, graph: str, seed: int, runs: Sequence[Record], colours: dict[str, str]) -> _World | None:
    beside = Path(next(case.folder for case in study.plan.cases if case.graph == graph)).parent.name
    file = study.folder / FOLDER / beside / f"{seed}.png"  # a graph may be called by its path
    try:
        drawn = _drawn(study, runs, colours, file)
    except DrawingError as error:
        return _World(seed, Markup(""), "", f"World {seed} of {graph} cannot be drawn: {error}")
    except GraphnavError:  # a log that cannot be read shows no path
        drawn = None
    if drawn is None:
        return None
    ends = dict.fromkeys(run.outcome for run in runs)
    counts = ", ".join(f"{sum(run.outcome == end for run in runs)} {end}" for end in ends)
    return _World(seed, embedded_picture(drawn, f"paths through world {seed} of {graph}", _MAX_PX), counts)


def _drawn(study: StudyResults, runs: Sequence[Record], colours: dict[str, str], file: Path) -> Path | None:
    """Draw the runs whose logs are there, the base on top; return ``file``, or None where they are not enough."""
    with ExitStack() as stack:
        recordings = {
            run.variant: stack.enter_context(Recording(log))
            for run in reversed(runs)
            if (log := study.folder / run.folder / RunFolder.LOG).is_file()
        }
        if not recordings:
            return None
        file.parent.mkdir(parents=True, exist_ok=True)
        with drawing():
            drawn: Path | None = study.catalog.hook.graphnav_draw_paths(
                recordings=recordings, colours=colours, file=file
            )
        return drawn


_CAUSES = {"contact": "Contact", "timeout": "Time was up", "failed": "The run broke down"}
_MAX_PICTURES = 24
_MAX_PICTURE_PX = 1180


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
    return _Failure(run, badge, embedded_picture(file, about, _MAX_PICTURE_PX))
