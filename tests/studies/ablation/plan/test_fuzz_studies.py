"""Whatever a study's file holds and whatever is typed, the answer is a plan or a user's error."""

import contextlib
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Problem, UserError
from graphnav.core.graph import Override
from graphnav.core.spec import write_value
from graphnav.studies.ablation.plan.build_plan import check_study
from graphnav.studies.ablation.study.command_line import study_of_command
from graphnav.studies.ablation.study.vary import parse_varies
from graphnav.studies.ablation.study.worlds import parse_seeds

STUDIES = Path(__file__).resolve().parents[3] / "errors" / "studies"
CALM = settings(
    deadline=None, max_examples=40, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)

KNOWN = """about graph graphs seeds one_at_a_time set vary metrics loop chain plane flow smooth robot sight run run.seed
toy.detector toy.guess judge.blind judge.oracle plane.rule flow.layers robot.noise_px run.until_s plane.in.flow
flow.flow smooth.flow sight.right sight.wrong 0:3 robot.map maps/empty.yaml plane,flow run.until_s=5 nowhere"""
WORDS = st.sampled_from(KNOWN.split())
ATOMS = WORDS | st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8)
TREES = st.recursive(
    ATOMS,
    lambda tree: st.lists(tree, max_size=3) | st.dictionaries(WORDS | st.text(max_size=4), tree, max_size=4),
    max_leaves=12,
)
CHOICES = st.lists(ATOMS, max_size=3) | st.dictionaries(
    WORDS | st.text(max_size=4), st.dictionaries(WORDS, ATOMS, max_size=2), max_size=3
)
FILES = st.fixed_dictionaries(
    {"graphs": st.lists(st.sampled_from(["loop", "chain"]), min_size=1, max_size=2) | TREES},
    optional={
        "vary": st.dictionaries(WORDS, CHOICES | TREES, max_size=3),
        "seeds": st.just("0:3") | st.lists(st.integers(0, 9), max_size=3) | TREES,
        "one_at_a_time": st.booleans() | TREES,
        "set": st.lists(WORDS, max_size=2) | TREES,
        "metrics": st.lists(WORDS, max_size=2) | TREES,
        "about": TREES,
    },
)
GOOD_AXES = {
    "plane": ("toy.detector", "toy.guess", "judge.blind", "judge.oracle"),
    "flow": ("toy.matcher", "toy.idle"),
    "flow.layers": (1, 3, 8, 9),
    "robot.noise_px": (0.0, 2, 1e3),
    "robot.map": (None, "maps/empty.yaml", "nowhere"),
}
GOOD_CHOICES = st.one_of(
    [
        st.tuples(st.just(name), st.lists(st.sampled_from(values), min_size=1, max_size=3, unique=True))
        for name, values in GOOD_AXES.items()
    ]
)
GOOD_SETS = st.lists(GOOD_CHOICES.map(lambda axis: (axis[0], axis[1][0])), max_size=2).map(dict)
GOOD = st.fixed_dictionaries(
    {
        "graphs": st.lists(st.sampled_from(["loop", "chain"]), min_size=1, max_size=2, unique=True),
        "seeds": st.just([0, 1]),
        "vary": st.dictionaries(st.text(min_size=1, max_size=3), st.dictionaries(st.text(max_size=3), GOOD_SETS))
        | st.lists(GOOD_CHOICES, min_size=1, max_size=3).map(dict),
        "one_at_a_time": st.booleans(),
    }
)
OPTIONS: st.SearchStrategy[list[str]] = st.just([]) | st.lists(
    st.tuples(WORDS, st.sampled_from(["=", "+=", "", ","]), st.lists(WORDS | st.text(max_size=4), max_size=3)).map(
        lambda parts: f"{parts[0]}{parts[1]}{','.join(parts[2])}"
    ),
    max_size=3,
)


@pytest.fixture(scope="module")
def judges() -> Catalog:
    catalog = Catalog()
    for file in (STUDIES.parent / "stages.py", STUDIES / "stages.py"):
        catalog.add_file(file)
    return catalog


@pytest.fixture
def _among_the_graphs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for file in (STUDIES / "graphs").glob("*.yaml"):
        Path(file.name).write_bytes(file.read_bytes())


@pytest.mark.usefixtures("_among_the_graphs")
@CALM
@given(FILES, OPTIONS, OPTIONS)
def test_any_study(judges: Catalog, tree: object, varies: list[str], sets: list[str]) -> None:
    check(judges, tree, varies, sets)


@pytest.mark.usefixtures("_among_the_graphs")
@CALM
@given(GOOD)
def test_studies_that_may_be_right(judges: Catalog, tree: object) -> None:
    check(judges, tree, [], [])


def check(catalog: Catalog, tree: object, varies: list[str], sets: list[str]) -> None:
    """Check that a study is refused, or its plan is sound."""
    Path("study.yaml").write_text(write_value(tree), encoding="utf-8")
    try:
        problems: list[Problem] = []
        changes, overrides = parse_varies(varies, problems), Override.parse_all(sets, problems)
        study = study_of_command(["study.yaml"], varies=changes, overrides=overrides, problems=problems)
        plan = check_study(study, catalog, "").plan
    except UserError:
        return
    own = [case for case in plan.cases if not case.same_as]
    assert len({case.folder for case in own}) == len(own)
    assert len(plan.cases) == len(plan.graphs) * len(plan.variants)
    assert plan.n_jobs == len(list(plan.jobs))
    assert sum(case.is_base for case in plan.cases) == len(plan.graphs)


@CALM
@given(st.text(st.sampled_from("0123456789:,[] -+.ab")) | st.text())
def test_any_seeds(text: str) -> None:
    with contextlib.suppress(UserError):
        seeds = parse_seeds(text)
        assert len(set(seeds)) == len(seeds) > 0
