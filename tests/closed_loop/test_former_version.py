"""Recordings of version 0.1.0 stay readable under the names of today: a log, a run folder and a study.

``tests/fixtures/v0_1_0`` was made by that version with the two YAML files in it: ``graphnav ablate study.yaml`` (of
which the logs and pictures were removed) and ``graphnav run small_drive --until 1.5``.
"""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import pytest
from graphnav_score.navigation import Navigation

from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.stage import UNDEFINED, FormerNames, metrics_of, params_of
from graphnav.studies.ablation.execution import read_plan
from graphnav.studies.ablation.results import pair_studies, read_records

FORMER = Path(__file__).parents[1] / "fixtures" / "v0_1_0"
RUN = FORMER / "run"
NEW_COLUMNS = {"role", "cause"}
"""Of ``results.csv``, since 0.5.0."""
NEW_METRICS = {
    "drive.sct", "drive.min_clearance_ahead_m", "drive.min_clearance_side_m",
    "sight.counted_frames_ratio", "sight.unjudged_obstacle_ratio", "sight.auroc_all",
    "sight.balanced_accuracy_all_ratio",
}  # fmt: skip


def renamed_parameters() -> list[tuple[str, str]]:
    """Return the former and the present names of all parameters of the installed stages."""
    catalog = Catalog()
    stages = [catalog.stage(f"{family}.{name}") for family in catalog.families() for name in catalog.names(family)]
    params = [param for stage in stages for param in params_of(stage).values()]
    return [(param.renamed_from, param.name) for param in params if param.renamed_from]


@pytest.fixture
def former_study(tmp_path: Path) -> Path:
    """Return a copy of the study's folder."""
    return Path(shutil.copytree(FORMER / "study", tmp_path / "former"))


def table_of(path: Path) -> list[dict[str, str]]:
    """Return the lines of ``results.csv`` under the names of today."""
    with path.open(newline="", encoding="utf-8") as file:
        return [{FormerNames.metric_now(name): value for name, value in row.items()} for row in csv.DictReader(file)]


def test_the_report_of_a_study_has_the_names_of_today(former_study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ablate", "--report", str(former_study)]) == 0
    assert "steer.forward (baseline)" in capsys.readouterr().out
    table = (former_study / "table.md").read_text(encoding="utf-8")
    for heading in ("drive.success ↑", "drive.min_clearance_m ↑", "drive.path_length_m ↓"):
        assert f"| {heading} |" in table
    assert "counts as drive.success 0, drive.spl 0; its other metrics" in table
    for path in former_study.glob("*.*"):
        assert path.name == "plan.json" or "least_clearance" not in path.read_text(encoding="utf-8"), path
    assert "drive.min_clearance_m" in (former_study / "results.csv").read_text(encoding="utf-8").partition("\n")[0]
    now, then = (table_of(folder / "results.csv") for folder in (former_study, FORMER / "study"))
    assert [{name: row[name] for name in row.keys() - NEW_COLUMNS} for row in now] == then, "the same values"


@pytest.mark.long
def test_a_study_compares_with_one_of_today(
    former_study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text = (FORMER / "small_drive.yaml").read_text(encoding="utf-8")
    for former, now in renamed_parameters():
        text = text.replace(f"{former}:", f"{now}:")
    Path("small_drive.yaml").write_text(text, encoding="utf-8")
    study = (FORMER / "study.yaml").read_text(encoding="utf-8")
    Path("study.yaml").write_text(
        study.replace("figures:", "metrics:").replace("least_clearance_m", "min_clearance_m"), encoding="utf-8"
    )
    assert main(["ablate", "study.yaml", "-o", "today", "--gallery", "0", "-j", "2"]) == 0
    _has_the_same_cells(table_of(FORMER / "study" / "results.csv"), table_of(Path("today/results.csv")))
    capsys.readouterr()
    assert main(["ablate", "--compare", str(former_study), "today", "-o", "pair.md"]) == 0
    assert "drive.min_clearance_m ↑ A" in Path("pair.md").read_text(encoding="utf-8")
    plans = [read_plan(former_study), read_plan(Path("today"))]
    (_, arrived), (_, touched) = (
        (row.variant, row.differences)
        for row in pair_studies(
            plans[0], read_records(plans[0], former_study), plans[1], read_records(plans[1], Path("today"))
        ).rows
    )
    assert arrived["drive.success"].n == arrived["drive.path_length_m"].n == 3
    assert touched["drive.min_clearance_m"].n == 3
    assert "drive.path_length_m" not in touched, "undefined today for drives that did not arrive"


def _has_the_same_cells(former: list[dict[str, str]], today: list[dict[str, str]]) -> None:
    """Check that today's results have the former cells, except values undefined for drives that did not arrive.

    Only outcomes are compared by value: the others depend on the processor.
    """
    declared = {f"drive.{name}": metric for name, metric in metrics_of(Navigation).items()}
    undefined = {name for name, metric in declared.items() if metric.if_failed == UNDEFINED}
    gone = {f"drive.{name}" for name in FormerNames.REPLACED_METRICS}
    for old, new in zip(former, today, strict=True):
        assert old.keys() - gone == new.keys() - NEW_METRICS - NEW_COLUMNS
        assert [old[name] for name in ("variant", "seed", "outcome")] == [
            new[n] for n in ("variant", "seed", "outcome")
        ]
        emptied = {name for name in old.keys() - gone if old[name] and not new[name]}
        assert emptied == (set() if new["outcome"] == "goal" else undefined)
        assert not {name for name in old.keys() - gone if new[name] and not old[name]}


def test_a_log_replays(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(RUN), "--tolerance", "1e-6,1e-4"]) == 0
    said = capsys.readouterr().out
    assert "metrics as recorded" in said
    assert "no differences" in said


def test_a_log_tells_what_made_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(RUN)]) == 0
    assert "run of the graph small_drive: 9 stages, seed 0" in capsys.readouterr().out


def test_a_log_is_drawn(tmp_path: Path) -> None:
    assert main(["figure", str(RUN), "-o", str(tmp_path)]) == 0
    assert {path.name for path in tmp_path.glob("*.png")} == {"map.png", "panels.png"}


def test_former_names_are_refused_in_files_that_people_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(FORMER / "small_drive.yaml", tmp_path)
    assert main(["check", "small_drive.yaml"]) == 2
    said = capsys.readouterr().err
    text = (FORMER / "small_drive.yaml").read_text(encoding="utf-8")
    refused = [(former, now) for former, now in renamed_parameters() if f"{former}:" in text]
    assert refused
    for former, now in refused:
        assert f"has no parameter '{former}'\n  did you mean '{now}'? It was renamed" in said
    vary = ["--vary", "plane=plane.ica,plane.affine", "--seeds", "0:3"]
    assert main(["ablate", "corridor_ccw", *vary, "--metrics", "drive.least_clearance_m"]) == 2
    said = capsys.readouterr().err
    assert "stage 'drive' has no metric 'least_clearance_m'\n  did you mean 'min_clearance_m'?" in said
    assert main(["ablate", "corridor_ccw", *vary, "--metrics", "drive.barn"]) == 2
    said = capsys.readouterr().err
    assert "stage 'drive' has no metric 'barn'\n  did you mean 'sct'?" in said
    with pytest.raises(SystemExit) as ended:
        main(["ablate", "corridor_ccw", *vary, "--figures", "drive.success"])
    assert ended.value.code == 2
    assert "unknown option --figures: did you mean '--metrics'?" in capsys.readouterr().err
