"""A variant is an oracle if what its first metric measures is made with true data."""

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Problem
from graphnav.core.graph import Override, load_graph
from graphnav.studies.ablation.plan.build_plan import check_study, variant_roles
from graphnav.studies.ablation.plan.checked_cases import CaseProblems, CheckedCase, check_cases
from graphnav.studies.ablation.plan.upstream import driving_stages, measured_stages
from graphnav.studies.ablation.plan.variants import expand
from graphnav.studies.ablation.study.command_line import study_of_command
from graphnav.studies.ablation.study.vary import parse_varies

CATALOG = Catalog()


def roles(graphs: str, *varies: str, sets: tuple[str, ...] = (), metrics: tuple[str, ...] = ()) -> list[str]:
    """Return the roles of a study's cases."""
    problems: list[Problem] = []
    study = study_of_command(
        graphs.split(),
        varies=parse_varies(varies, problems),
        overrides=Override.parse_all(sets, problems),
        seeds="0:2",
        problems=problems,
        metrics=metrics,
    )
    assert not problems
    return [case.role for case in check_study(study, CATALOG, "graphnav ablate ...").plan.cases]


def test_of_stages_that_the_axes_put_in() -> None:
    planes = "plane=plane.ica,plane.residual,plane.truth"
    assert roles("corridor_ccw", planes) == ["method", "baseline", "oracle"]
    assert roles("corridor_ccw", planes, metrics=("sense.epe_px",)) == ["method", "baseline", "oracle"]


def test_an_oracle_that_all_variants_have_makes_all_of_them_oracles() -> None:
    steers = "steer=steer.pca,steer.forward"
    assert roles("corridor_ccw", steers, sets=("plane=plane.truth",)) == ["oracle", "oracle"]
    assert roles("corridor_ccw", steers) == ["method", "baseline"]


def test_an_oracle_may_also_lie_before_what_is_varied() -> None:
    planes = "plane=plane.ica,plane.homography"
    assert roles("corridor_ccw", planes, sets=("flow=flow.truth",)) == ["oracle", "oracle"]
    found = roles("corridor_ccw", planes, sets=("planar=planar.truth",))
    assert found == ["oracle", "method"], "the homography takes no planar flow"


@pytest.mark.parametrize("metric", ["drive.success", "drive.success - drive.spl"])
def test_the_drive_counts_where_the_drive_is_measured(metric: str) -> None:
    planes, driven = "plane=plane.ica,plane.affine", ("steer=steer.oracle",)
    assert roles("corridor_ccw", planes, sets=driven, metrics=(metric, "sight.auroc")) == ["oracle", "oracle"]
    assert roles("corridor_ccw", planes, sets=driven, metrics=("sight.auroc", metric)) == ["method", "method"]


def test_the_common_drive_of_a_measuring_graph_does_not_count() -> None:
    assert roles("measure_detectors", "ica.rule=mad,fixed") == ["method", "method"]
    metrics = ("ica_score.auroc", "ica_score.auroc - ica_twin_score.auroc")
    assert roles("measure_conditions", "robot.tilt_deg=75,65", metrics=metrics) == ["method", "method"]
    flows = roles("measure_flow", "flow=flow.lucas_kanade,flow.truth", metrics=("sense.epe_px", "ica_sight.auroc"))
    assert flows == ["method", "oracle"]


def test_a_metric_of_another_graph_is_passed_over() -> None:
    metrics = ("drive.success", "ica_sight.auroc")
    found = roles("corridor_ccw measure_flow", "flow=flow.lucas_kanade,flow.dis", metrics=metrics)
    assert found == ["method", "method", "oracle", "oracle"], "measure_flow has no score of the drive: ica_sight counts"


def test_what_a_metric_measures() -> None:
    graph = load_graph("corridor_ccw", CATALOG)
    assert driving_stages(graph) == {"flow", "planar", "plane", "steer", "control", "guard"}
    assert measured_stages(graph, "drive") == driving_stages(graph)
    assert measured_stages(graph, "sense") == {"sense", "flow"}
    assert measured_stages(graph, "sight") == {"sight", "flow", "planar", "plane"}


def test_the_measured_stages_of_a_case_are_compared_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    identity_of = CheckedCase.identity_of

    def counted(case: CheckedCase, stages: frozenset[str]) -> object:
        asked.append(case.variant.name)
        return identity_of(case, stages)

    problems: list[Problem] = []
    axes = parse_varies(["steer.gain=1,2,3,4,5,6"], problems)
    study = study_of_command(["corridor_ccw"], varies=axes, seeds="0:2", problems=problems)
    cases = check_cases(study, expand(study), CATALOG, CaseProblems(study.axes))
    monkeypatch.setattr(CheckedCase, "identity_of", counted)
    assert len(variant_roles(cases, ["drive.success"])) == len(asked) == len(cases)
