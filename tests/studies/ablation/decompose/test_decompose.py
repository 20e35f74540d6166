"""A decomposed study swaps the stages of a drive for their oracles, found by their role alone."""

from pathlib import Path

import pytest

import graphnav
from graphnav.core.catalog import Catalog
from graphnav.core.errors import Problem, UserError
from graphnav.core.graph import Override
from graphnav.studies.ablation.decompose import decomposed_study
from graphnav.studies.ablation.plan import Plan, check_study
from graphnav.studies.ablation.plan.plan_file import load_plan, save_plan
from graphnav.studies.ablation.results import losses
from graphnav.studies.ablation.study import Study, study_of_command

CATALOG = Catalog()
STAGES = ("flow", "planar", "plane", "steer")
VARIANTS = ("none", *STAGES, "flow+planar", "flow+planar+plane", "flow+planar+plane+steer")

SECOND_ORACLE = '''
"""Another oracle."""

from typing import ClassVar

from graphnav import Plane, Role, Stage, Truth, hookimpl

FAMILY = "plane"


class Second(Stage):
    """Another plane of the truth."""

    role: ClassVar[Role] = "oracle"

    def step(self, truth: Truth) -> Plane | None:
        return None


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Second]
'''

TWO_PLANES = '''
"""A detector, and an oracle whose two planes could both take its place."""

from typing import ClassVar, NamedTuple

from graphnav import Flow, Plane, Role, Stage, Truth, hookimpl

FAMILY = "twice"


class Planes(NamedTuple):
    plane: Plane
    far: Plane


class Detector(Stage):
    """A plane of a flow."""

    def step(self, flow: Flow) -> Plane | None:
        return None


class Oracle(Stage):
    """Two planes of the truth."""

    role: ClassVar[Role] = "oracle"

    def step(self, truth: Truth) -> Planes:
        raise NotImplementedError


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Detector, Oracle]
'''


def study_of(*graphs: str, metrics: tuple[str, ...] = (), catalog: Catalog = CATALOG) -> Study:
    asked = study_of_command(graphs, seeds="0:2", metrics=metrics, may_vary_nothing=True)
    return decomposed_study(asked, catalog)


@pytest.fixture(scope="module")
def plan() -> Plan:
    """Return the plan of the decomposed corridor."""
    return check_study(study_of("corridor_ccw"), CATALOG, "graphnav ablate corridor_ccw --decompose").plan


def test_swaps_one_stage_at_a_time_and_cumulatively(plan: Plan) -> None:
    assert plan.variants == VARIANTS
    assert plan.base == "none"
    own = {case.variant: case for case in plan.cases if case.labels["drive"] == "own drive"}
    assert own["plane"].uses["plane"] == "plane.truth"
    assert [own["flow+planar+plane+steer"].uses[stage] for stage in ("flow", "plane", "steer")] == [
        "flow.truth",
        "plane.truth",
        "steer.oracle",
    ]
    assert own["none"].role == "method"
    assert {case.role for name, case in own.items() if name != "none"} == {"oracle"}


def test_shows_the_metrics_that_sum_up_a_drive(plan: Plan) -> None:
    assert plan.metrics == ("drive.success", "drive.spl", "sight.auroc")
    assert [plan.is_of_frames(metric) for metric in plan.metrics] == [False, False, True]


def test_all_variants_meet_the_same_frames_where_the_oracle_drives(plan: Plan) -> None:
    own, common = (
        {case.variant: case.drives_as for case in plan.cases if case.labels["drive"] == label}
        for label in ("own drive", "oracle's drive")
    )
    assert set(common.values()) == {"none"}
    assert own == {name: name for name in VARIANTS}, "behind a true plane the guard still reads the flow"


def test_the_stages_that_drive_are_told_of_each_variant(plan: Plan) -> None:
    driving = {case.variant: case.driving for case in plan.cases if case.labels["drive"] == "own drive"}
    assert driving["none"] == ("flow", "planar", "plane", "steer", "control", "guard")
    assert driving["flow+planar+plane"] == ("flow", "plane", "steer", "control", "guard")


def test_without_a_metric_of_frames_each_variant_drives_itself() -> None:
    study = study_of("corridor_ccw", "pillars", metrics=("drive.success",))
    assert [axis.name for axis in study.axes] == ["oracles"]
    assert study.within == ()


def test_the_plan_is_kept_with_what_it_decomposes(plan: Plan, tmp_path: Path) -> None:
    save_plan(plan, tmp_path / "plan.json")
    kept = load_plan(tmp_path / "plan.json")
    assert kept.decomposition == plan.decomposition
    assert kept.cases == plan.cases


def test_a_family_of_two_oracles_is_refused(tmp_path: Path) -> None:
    (tmp_path / "second.py").write_text(SECOND_ORACLE)
    catalog = Catalog()
    catalog.add_file(tmp_path / "second.py")
    with pytest.raises(UserError, match=r"the family 'plane' has 2 oracles: plane\.second, plane\.truth"):
        study_of("corridor_ccw", catalog=catalog)


def test_without_a_graph_there_is_nothing_to_swap() -> None:
    with pytest.raises(UserError, match="--decompose: no graph is named"):
        study_of()


def test_each_variant_drives_itself_where_no_oracle_can_drive_for_all(tmp_path: Path) -> None:
    (tmp_path / "twice.py").write_text(TWO_PLANES)
    catalog = Catalog()
    catalog.add_file(tmp_path / "twice.py")
    graph = tmp_path / "mine.yaml"
    graph.write_text("extends: corridor_ccw\nstages: {plane: {use: twice.detector}}\n")
    study = study_of(str(graph), catalog=catalog)
    assert study.decomposition is not None
    assert study.decomposition.oracles["plane"] == "twice.oracle"
    assert not study.decomposition.has_common_drive, "the guard would not know which of the oracle's planes to read"
    assert [axis.name for axis in study.axes] == ["oracles"]
    assert study.within == ()
    assert "sight.auroc" in study.metrics


@pytest.mark.parametrize("text", ["plane=plane.affine", "steer=steer.balance"])
def test_an_oracle_takes_the_place_of_a_stage_that_was_put_in_for_all(text: str) -> None:
    problems: list[Problem] = []
    overrides = Override.parse_all([text], problems)
    asked = study_of_command(["corridor_ccw"], seeds="0:2", overrides=overrides, may_vary_nothing=True)
    stage, _, use = text.partition("=")
    plan = check_study(decomposed_study(asked, CATALOG), CATALOG, "graphnav ablate ...").plan
    own = {case.variant: case.uses[stage] for case in plan.cases if case.labels["drive"] == "own drive"}
    assert own["none"] == use
    assert own[stage] == {"plane": "plane.truth", "steer": "steer.oracle"}[stage]
    assert set(own.values()) == {use, own[stage]}


def test_of_a_swap_of_several_stages_the_others_stay() -> None:
    swap, setting, later = Override.parse_all(["flow,back=flow.dis", "flow.gain=2", "flow=flow.truth"], [])
    (kept, other) = Override.without_replaced([swap, setting], [later])
    assert (str(kept.target), kept.value, other) == ("back", "flow.dis", setting)


def test_one_at_a_time_is_refused_by_its_name() -> None:
    asked = study_of_command(["corridor_ccw"], seeds="0:2", one_at_a_time=True, may_vary_nothing=True)
    with pytest.raises(UserError) as error:
        decomposed_study(asked, CATALOG)
    assert str(error.value) == (
        "--decompose: one at a time is for axes; a decomposition swaps one stage at a time, and cumulatively\n"
        "  leave out --one-at-a-time"
    )


def test_conditions_are_refused_by_their_name() -> None:
    asked = study_of_command(["corridor_ccw"], seeds="0:2", within=["nonsense"], may_vary_nothing=True)
    with pytest.raises(UserError, match="within is for axes that are conditions; a decomposition has none"):
        decomposed_study(asked, CATALOG)


@pytest.mark.long
def test_runs_show_the_same_drive_and_what_each_oracle_adds(tmp_path: Path) -> None:
    made = graphnav.ablate(
        "corridor_ccw", decompose=True, seeds=[3], set={"run.until_s": 1.2}, folder=tmp_path, jobs=1, gallery=0
    )
    driven = {
        record.variant: record.metrics["drive.mean_clearance_m"]
        for record in made.records
        if record.graph.endswith("oracle's drive")
    }
    assert set(driven) == set(VARIANTS)
    assert len({*driven.values()}) == 1
    sight = next(of for of in losses(made.plan, made.records) if of.metric == "sight.auroc")
    assert sight.is_common
    assert sight.cumulative[-1].is_same, "who steers does not change what is seen on the oracle's drive"
    found = [step.estimate.mean for step in sight.cumulative if step.estimate is not None]
    assert sight.as_it_is.mean < found[-1], "the true plane is better than the detected one"
    assert (tmp_path / "decompose.png").read_bytes().startswith(b"\x89PNG")
    assert "Where it is lost" in made.report.read_text()
    assert "## Where it is lost" in (tmp_path / "table.md").read_text()
