"""Maps with the paths that were driven, and how failures ended."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from graphnav import GraphnavError, Recording
from graphnav.core.catalog import Catalog
from graphnav.core.errors import DrawingError
from graphnav.core.pictures import DRAWING_FAMILY, drawing
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Outcome
from graphnav.studies.ablation.plan import Case, Job, Plan
from graphnav.studies.ablation.report.html.rendering import counted, embedded_picture, rendered
from graphnav.studies.ablation.report.html.study_results import StudyResults, badge_of, colours_of, own_variants
from graphnav.studies.ablation.results import Record, failure_folder, is_failure, read_record
from graphnav.studies.ablation.worker import ENDING

FOLDER = "paths"
_FIRST, _DISPUTED, _MANY_GRAPHS = 2, 3, 4
_FIRST_OF_MANY, _DISPUTED_OF_MANY = 1, 2
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
    variants = _variants(study.plan)
    colours = colours_of(study.plan)
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


class EarlyMaps:
    """Draws the maps of the first worlds while other runs are made: each as soon as its last path is there.

    A world of which a run existed before is drawn with the report.
    """

    def __init__(self, plan: Plan, catalog: Catalog, folder: Path) -> None:
        self._plan, self._catalog, self._folder = plan, catalog, folder
        self._colours = colours_of(plan)
        self._worlds: dict[tuple[str, int], dict[str, Record | None]] = {}
        """The runs of each world by the folder of their case, in the order of variants; None: not made yet."""
        for graph in plan.graphs:
            cases = [plan.case(graph, variant) for variant in _variants(plan)]
            own = dict.fromkeys(case.folder for case in cases if not case.same_as)
            self._worlds |= {(graph, seed): dict(own) for seed in _first_worlds(plan, cases[0])}
        self.drawn: set[Path] = set()

    def add(self, job: Job) -> None:
        """Add a run that was made; draw its world if it is a first one, of which it is the last."""
        runs = self._worlds.get((job.case.graph, job.seed), {})
        if job.case.folder not in runs:
            return
        runs[job.case.folder] = read_record(job.case, job.seed, self._folder / job.folder / RunFolder.SUMMARY)
        made = [run for run in runs.values() if run is not None]
        if len(made) < len(runs):
            return
        file = _file(self._plan, self._folder, job.case.graph, job.seed)
        with suppress(GraphnavError):  # the report tells of it
            self._catalog.load(DRAWING_FAMILY)
            if _drawn(self._folder, self._catalog, made, self._colours, file) is not None:
                self.drawn.add(file)


def _variants(plan: Plan) -> Sequence[str]:
    """Return whose paths are drawn: of each role the first few, the base among them."""
    roles = {case.variant: case.role for case in plan.cases}
    used = dict.fromkeys(_MAX_PATHS, 0)
    kept = []
    for variant in own_variants(plan):
        role = roles[variant]
        used[role] += 1
        if used[role] <= _MAX_PATHS[role]:
            kept.append(variant)
    return kept


def _worlds(study: StudyResults, graph: str, variants: Sequence[str]) -> Sequence[int]:
    """Return the seeds of the worlds to draw, the first ones first."""
    case = study.own_rows(graph)[0].case
    begin, seeds = _first_worlds(study.plan, case), study.plan.seeds_of(case)
    disputed = _DISPUTED if len(study.plan.graphs) <= _MANY_GRAPHS else _DISPUTED_OF_MANY
    outcomes: dict[int, list[str]] = {}
    for variant in variants:
        if study.plan.case(graph, variant).role == "method":
            for run in study.runs.get((graph, variant), ()):
                outcomes.setdefault(run.seed, []).append(run.outcome)
    doubt = {
        seed: sum(one != Outcome.GOAL for one in of) * sum(one == Outcome.GOAL for one in of)
        for seed, of in outcomes.items()
    }
    rest = sorted((s for s in seeds if s not in begin), key=lambda s: (-doubt.get(s, 0), s))
    doubtful = [seed for seed in rest if doubt.get(seed, 0) > 0][:disputed]
    return [*begin, *(doubtful or rest[:disputed])]


def _first_worlds(plan: Plan, case: Case) -> Sequence[int]:
    """Return the first seeds of a graph, whose worlds are drawn in any case."""
    return plan.seeds_of(case)[: _FIRST if len(plan.graphs) <= _MANY_GRAPHS else _FIRST_OF_MANY]


def _file(plan: Plan, folder: Path, graph: str, seed: int) -> Path:
    """Return the file of a map; a graph may be called by its path."""
    beside = Path(next(case.folder for case in plan.cases if case.graph == graph)).parent.name
    return folder / FOLDER / beside / f"{seed}.png"


def _map(study: StudyResults, graph: str, seed: int, runs: Sequence[Record], colours: dict[str, str]) -> _World | None:
    file = _file(study.plan, study.folder, graph, seed)
    try:
        drawn = file if file in study.drawn else _drawn(study.folder, study.catalog, runs, colours, file)
    except DrawingError as error:
        return _World(seed, Markup(""), "", f"World {seed} of {graph} cannot be drawn: {error}")
    except GraphnavError:  # a log that cannot be read shows no path
        drawn = None
    if drawn is None:
        return None
    ends = dict.fromkeys(run.outcome for run in runs)
    counts = ", ".join(f"{sum(run.outcome == end for run in runs)} {end}" for end in ends)
    return _World(seed, embedded_picture(drawn, f"paths through world {seed} of {graph}", _MAX_PX), counts)


def _drawn(folder: Path, catalog: Catalog, runs: Sequence[Record], colours: dict[str, str], file: Path) -> Path | None:
    """Draw the runs whose logs are there, the base on top; return ``file``, or None where they are not enough."""
    with ExitStack() as stack:
        recordings = {
            run.variant: stack.enter_context(Recording(log))
            for run in reversed(runs)
            if (log := folder / run.folder / RunFolder.LOG).is_file()
        }
        if not recordings:
            return None
        file.parent.mkdir(parents=True, exist_ok=True)
        with drawing():
            drawn: Path | None = catalog.hook.graphnav_draw_paths(recordings=recordings, colours=colours, file=file)
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
