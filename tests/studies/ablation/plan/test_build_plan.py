"""A plan holds every graph with every variant, checked, and the pending runs."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Problem, UserError
from graphnav.core.graph import Override, load_graph, resolved_yaml
from graphnav.core.spec import write_value
from graphnav.studies.ablation.plan.build_plan import check_study
from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.plan.plan_file import load_plan, save_plan
from graphnav.studies.ablation.study.command_line import study_of_command
from graphnav.studies.ablation.study.vary import parse_varies

STUDIES = Path(__file__).resolve().parents[3] / "errors" / "studies"
GRAPHS = STUDIES / "graphs"

MakePlan = Callable[..., Plan]


@pytest.fixture(scope="module")
def judges() -> Catalog:
    """Return a catalog with the families ``toy`` and ``judge``."""
    catalog = Catalog()
    for file in (STUDIES.parent / "stages.py", STUDIES / "stages.py"):
        catalog.add_file(file)
    return catalog


@pytest.fixture
def plan(judges: Catalog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> MakePlan:
    """Return what makes plans of the toy graphs, which are in the working folder."""
    monkeypatch.chdir(tmp_path)
    for file in GRAPHS.glob("*.yaml"):
        (tmp_path / file.name).write_bytes(file.read_bytes())

    def made(
        *varies: str,
        names: Sequence[str] = ("loop",),
        plugins: Sequence[Path] = (),
        sets: Sequence[str] = (),
        **options: Sequence[str],
    ) -> Plan:
        problems: list[Problem] = []
        changes, overrides = parse_varies(varies, problems), Override.parse_all(sets, problems)
        study = study_of_command(
            names,
            varies=changes,
            overrides=overrides,
            seeds="0:3",
            problems=problems,
            metrics=options.get("metrics", ()),
            within=options.get("within", ()),
        )
        return check_study(study, judges, "graphnav ablate ...", plugins).plan

    return made


def test_every_graph_with_every_variant_the_base_first(plan: MakePlan) -> None:
    made = plan("plane=toy.detector,judge.blind", "flow.layers=2,3", names=("loop", "chain"))
    assert [(c.graph, c.variant) for c in made.cases] == [(g, v) for g in ("loop", "chain") for v in made.variants]
    assert made.variants == (
        "toy.detector + flow.layers=2",
        "toy.detector + flow.layers=3",
        "judge.blind + flow.layers=2",
        "judge.blind + flow.layers=3",
    )
    assert [case.is_base for case in made.cases] == [True, False, False, False] * 2
    assert made.base == made.variants[0]
    assert made.axes == {"plane": ("toy.detector", "judge.blind"), "flow.layers": ("flow.layers=2", "flow.layers=3")}
    assert made.case("chain", made.variants[3]).labels == {"plane": "judge.blind", "flow.layers": "flow.layers=3"}


def test_within_a_condition_the_base_is_its_own(plan: MakePlan) -> None:
    varies = ("plane=toy.detector,judge.blind", "flow.layers=2,3")
    made, crossed = (
        plan(*varies, names=("loop", "chain"), within=["flow.layers"]),
        plan(*varies, names=("loop", "chain")),
    )
    graphs = ("loop, flow.layers=2", "loop, flow.layers=3", "chain, flow.layers=2", "chain, flow.layers=3")
    assert (made.graphs, made.sources) == (graphs, ("loop", "chain"))
    assert [(c.graph, c.variant, c.is_base) for c in made.cases] == [
        (graph, variant, variant == "toy.detector") for graph in graphs for variant in ("toy.detector", "judge.blind")
    ]
    assert {c.folder for c in made.cases} == {c.folder for c in crossed.cases}
    assert [c.swapped for c in made.cases[2:4]] == [(), ("plane",)]


def test_a_case_is_the_graph_with_its_sets(plan: MakePlan, judges: Catalog) -> None:
    made = plan("plane=toy.detector,judge.blind", sets=["robot.noise_px=1"], names=("loop", "chain"))
    for case in made.cases:
        graph = load_graph(case.graph, judges, case.overrides)
        assert case.overrides[0] == Override.parse("robot.noise_px=1")
        assert case.graph_yaml == resolved_yaml(graph)
        assert case.uses == {node.name: node.use for node in graph.nodes}
        assert list(case.uses) == [node.name for node in graph.nodes]


def test_folders_are_unique_and_below_the_study(plan: MakePlan) -> None:
    Path("lab").mkdir()
    Path("lab/loop.yaml").write_bytes(Path("loop.yaml").read_bytes())
    made = plan("plane=toy.detector,judge.blind", names=("loop", "lab/loop.yaml"))
    folders = [case.folder for case in made.cases]
    assert len(set(folders)) == 4
    assert all(Path(folder).parts[0] == "runs" and len(Path(folder).parts) == 3 for folder in folders)
    assert plan("plane=toy.detector,judge.blind").cases[1].folder == "runs/loop/judge.blind"


def test_graphs_that_come_out_the_same_are_run_once(plan: MakePlan) -> None:
    made = plan("plane=toy.detector,toy.guess", "smooth.alpha=0.1,0.5", names=("chain",))
    assert [case.same_as for case in made.cases] == ["", "", "", "toy.guess + smooth.alpha=0.1"]
    assert made.cases[3].folder == made.cases[2].folder
    assert made.n_jobs == 9
    assert len({job.folder for job in made.jobs}) == 9


def test_a_value_that_is_the_default_is_the_same_graph(plan: MakePlan) -> None:
    made = plan("robot.noise_px=2,2.0,3")
    assert [case.same_as for case in made.cases] == ["", "robot.noise_px=2", ""]


def test_same_graphs_of_other_names_are_run_each(plan: MakePlan) -> None:
    Path("copy.yaml").write_bytes(Path("loop.yaml").read_bytes())
    assert not any(case.same_as for case in plan("plane=toy.detector,judge.blind", names=("loop", "copy")).cases)


def test_a_case_has_the_highest_role_among_its_choices(plan: MakePlan) -> None:
    made = plan("plane=toy.detector,judge.blind,judge.oracle", "robot.noise_px=1,2")
    assert [case.role for case in made.cases] == ["method"] * 2 + ["baseline"] * 2 + ["oracle"] * 2
    base = plan("plane=judge.oracle,toy.detector").cases
    assert [case.role for case in base] == ["oracle", "method"]


def test_what_all_runs_have_makes_no_role(plan: MakePlan) -> None:
    made = plan("robot.noise_px=1,2", sets=["plane=judge.oracle"])
    assert [case.role for case in made.cases] == ["method", "method"]


def test_swapped_stages_are_those_that_the_base_has_not(plan: MakePlan) -> None:
    made = plan("plane=judge.blind,toy.detector", "flow.layers=2,3")
    assert [case.swapped for case in made.cases] == [(), (), ("plane",), ("plane",)]


def test_notices_say_what_changed_and_nothing_of_what_did_not(plan: MakePlan) -> None:
    base, other = plan("plane=toy.detector,toy.guess", names=("chain",)).cases
    assert base.notices == ()
    assert other.notices[0].startswith("plane: toy.detector swapped for toy.guess")
    assert "smooth: pruned, no stage reads it any more" in other.notices


def test_metrics_know_which_way_is_better(plan: MakePlan) -> None:
    made = plan("plane=toy.detector,judge.blind", metrics=["sight.wrong,sight.right,sight.wrong - sight.right"])
    assert made.metrics == ("sight.wrong", "sight.right", "sight.wrong - sight.right")
    assert [made.better(column) for column in made.metrics] == ["lower", "higher", "lower"]
    assert {name: metric.help for name, metric in made.declared.items()} == {
        "sight.right": "What is right.",
        "sight.wrong": "What is wrong.",
    }
    assert plan("plane=toy.detector,judge.blind").metrics == ()


def test_a_plan_reads_back_as_it_was_written(plan: MakePlan, tmp_path: Path) -> None:
    made = plan(
        "plane=toy.detector,judge.blind",
        "robot.noise_px=1,1e1",
        metrics=["sight.right"],
        plugins=[Path("mine.py")],
        names=("loop", "chain"),
    )
    save_plan(made, tmp_path / "plan.json")
    assert load_plan(tmp_path / "plan.json") == made
    assert made.plugins == (str(tmp_path / "mine.py"),)
    assert made.command == "graphnav ablate ..."
    assert made.versions["python"]


def test_the_smallest_difference_that_matters_is_the_first_metrics(plan: MakePlan, tmp_path: Path) -> None:
    made = plan("plane=toy.detector,judge.blind")
    smallest = {"sight.right": 0.1, "sight.wrong": 0.2}
    declared = {name: replace(made.metric(name), min_difference=value) for name, value in smallest.items()}
    save_plan(replace(made, declared=declared), tmp_path / "plan.json")
    read = load_plan(tmp_path / "plan.json")
    columns = ("sight.right", "sight.wrong - sight.right", "sight.wrong / sight.right", "sight.never")
    assert [read.min_difference(column) for column in columns] == [0.1, 0.2, 0.0, 0.0]


STUDY = "graph: loop\nseeds: [0]\nvary: {robot.map: [here.yaml, there.yaml, maps/empty.yaml]}\n"


def test_paths_of_a_study_are_beside_it_then_where_set_finds_them_then_what_ships(
    plan: MakePlan, tmp_path: Path
) -> None:
    (tmp_path / "lab").mkdir()
    for name in ("here.yaml", "there.yaml", "lab/here.yaml"):
        (tmp_path / name).touch()
    (tmp_path / "lab/study.yaml").write_text(STUDY, encoding="utf-8")
    made = plan(names=("lab/study.yaml",))
    assert [[override.value for override in case.overrides] for case in made.cases] == [
        [f"{tmp_path}/lab/here.yaml"],
        ["there.yaml"],
        ["maps/empty.yaml"],
    ]
    assert made.axes["robot.map"][0] == "robot.map=here.yaml"


def test_paths_of_the_command_line_are_those_of_the_working_folder(plan: MakePlan, tmp_path: Path) -> None:
    (tmp_path / "lab").mkdir()
    for name in ("here.yaml", "there.yaml", "lab/here.yaml"):
        (tmp_path / name).touch()
    (tmp_path / "lab/study.yaml").write_text(STUDY, encoding="utf-8")
    made = plan("robot.map=there.yaml,here.yaml", names=("lab/study.yaml",))
    assert made.cases[1].overrides == (Override.parse("robot.map=here.yaml"),)


def test_words_that_are_no_paths_stay_whatever_lies_beside_the_study(plan: MakePlan, tmp_path: Path) -> None:
    (tmp_path / "lab").mkdir()
    (tmp_path / "lab/otsu").touch()
    text = "graph: loop\nvary: {plane.rule: [otsu, mad]}\n"
    (tmp_path / "lab/study.yaml").write_text(text, encoding="utf-8")
    assert plan(names=("lab/study.yaml",)).cases[0].overrides == (Override.parse("plane.rule=otsu"),)


def test_a_missing_path_beside_the_study_is_said_at_its_value(plan: MakePlan, tmp_path: Path) -> None:
    text = "graph: loop\nvary: {robot.map: [maps/empty.yaml, nowhere.yaml]}\n"
    (tmp_path / "study.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(UserError, match=r"^study\.yaml:2:37: in loop: toy\.robot: there is no map nowhere\.yaml"):
        plan(names=("study",))


def test_a_detector_of_ones_own_gets_its_cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(
        "import numpy as np\nfrom graphnav import Flow, Plane, Stage, hookimpl\nFAMILY = 'plane'\n\n\n"
        "class Mine(Stage):\n    def step(self, flow: Flow) -> Plane:\n        raise NotImplementedError\n\n\n"
        "@hookimpl\ndef graphnav_stages():\n    return [Mine]\n",
        encoding="utf-8",
    )
    catalog = Catalog()
    catalog.add_file(Path("mine.py"))
    varies = parse_varies(["plane+=plane.mine", "planar=planar.motion"], [])
    study = study_of_command(["detectors"], varies=varies, seeds="0:2")
    made = check_study(study, catalog, "", [Path("mine.py")]).plan
    mine = [case for case in made.cases if case.labels["plane"] == "plane.mine"]
    assert {case.graph for case in mine} == set(made.graphs)
    assert all(case.uses["plane"] == "plane.mine" for case in mine)
    assert all("planar" not in case.uses for case in mine)
    assert not any(case.same_as for case in mine)


def test_a_plan_holds_overrides_as_data(plan: MakePlan, tmp_path: Path) -> None:
    made = plan("plane=toy.detector,judge.blind", sets=["robot.noise_px=1e0"])
    save_plan(made, tmp_path / "plan.json")
    data = json.loads((tmp_path / "plan.json").read_text())
    assert data["cases"][1]["overrides"] == {"robot.noise_px": 1.0, "plane": "judge.blind"}


def test_plans_of_earlier_versions_are_read(plan: MakePlan, tmp_path: Path) -> None:
    made = plan("plane=toy.detector,judge.blind", sets=["robot.noise_px=1.5", "flow.layers=2"])
    save_plan(made, tmp_path / "plan.json")
    data = json.loads((tmp_path / "plan.json").read_text())
    for case in data["cases"]:
        case["sets"] = [f"{target}={write_value(value)}" for target, value in case.pop("overrides").items()]
    for metric in data["declared"].values():
        assert metric.pop("min_difference") == 0.0
    (tmp_path / "plan.json").write_text(json.dumps(data))
    assert load_plan(tmp_path / "plan.json") == made
