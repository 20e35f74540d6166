"""A study in MLflow: a run for each case, read back by MLflow itself."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import pytest

from graphnav.core.cli import main

TOYS = Path(__file__).parents[1] / "ablation" / "execution" / "toy_stages.py"
GRAPH = "run: {until_s: 5}\nstages:\n  robot: {use: toy.walker}\n  drive: {use: toy.distance, in: {twist: robot}}\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of a finished toy study."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MLFLOW_TRACKING_URI", (tmp_path / "store").as_uri())
    monkeypatch.setenv("MLFLOW_ALLOW_FILE_STORE", "true")
    (tmp_path / "toy.yaml").write_text(GRAPH)
    words = ["ablate", "toy", "--plugin", str(TOYS), "--vary", "robot.odd=fine,contact", "--seeds", "0:4", "-o", "out"]
    assert main([*words, "-j", "1", "--gallery", "0"]) == 0
    return tmp_path / "out"


@pytest.mark.filterwarnings("default")  # of MLflow itself
def test_every_case_is_a_run_with_parameters_metrics_and_tables(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tracking = pytest.importorskip("mlflow.tracking")
    assert main(["ablate", "--report", "out", "--export", "mlflow"]) == 0
    uri = (folder.parent / "store").as_uri()
    assert f"mlflow: {uri}" in capsys.readouterr().out
    client: Any = tracking.MlflowClient(uri)
    runs = client.search_runs([client.get_experiment_by_name("toy").experiment_id])
    found = {run.data.params["variant"]: run for run in runs}
    assert found.keys() == {"robot.odd=fine", "robot.odd=contact"}
    contact = found["robot.odd=contact"]
    assert contact.data.params["axis.robot.odd"] == "robot.odd=contact"
    assert contact.data.params["use.drive"] == "toy.distance"
    assert contact.data.metrics["drive.way_m"] == 4.5
    assert contact.data.metrics["drive.way_m.difference"] == 4.5 - 10.75
    assert contact.data.metrics["worlds"] == 4
    assert {file.path for file in client.list_artifacts(contact.info.run_id)} == {"table.md", "results.csv"}
    assert contact.info.status == "FINISHED"


def test_without_the_package_the_extra_is_named(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with monkeypatch.context() as without:
        for module in ("mlflow", "mlflow.exceptions"):  # whether it is installed, imported before, or neither
            without.setitem(sys.modules, module, None)
        assert main(["ablate", "--report", str(folder), "--export", "mlflow"]) == 2
    assert capsys.readouterr().err.startswith("--export mlflow needs MLflow\n  ")


@pytest.mark.filterwarnings("default")  # of MLflow itself
def test_without_a_server_the_way_to_start_one_is_named(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("mlflow.tracking")
    monkeypatch.delenv("MLFLOW_TRACKING_URI")
    assert main(["ablate", "--report", str(folder), "--export", "mlflow"]) == 2
    assert "no MLflow server is named\n  start one by 'mlflow server'" in capsys.readouterr().err


def test_a_study_that_is_made_is_not_exported(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert folder.parent == Path.cwd()
    assert main(["ablate", "toy", "--export", "mlflow"]) == 2
    assert capsys.readouterr().err.startswith("--export is for --report")


AXES = """\
graph: toy
seeds: 0:2
vary:
  a (b):
    fine: {robot.odd: fine}
    rough: {robot.odd: contact}
  a [b]/:
    one: {robot.times: 1}
    two: {robot.times: 2}
"""


@pytest.mark.filterwarnings("default")  # of MLflow itself
def test_characters_that_mlflow_forbids_are_replaced(folder: Path) -> None:
    tracking = pytest.importorskip("mlflow.tracking")
    (folder.parent / "named.yaml").write_text(AXES)
    words = ["ablate", "named.yaml", "--plugin", str(TOYS), "-o", "named", "-j", "1", "--gallery", "0"]
    assert main(words) == 0
    assert main(["ablate", "--report", "named", "--export", "mlflow"]) == 0
    client: Any = tracking.MlflowClient((folder.parent / "store").as_uri())
    runs = client.search_runs([client.get_experiment_by_name("named").experiment_id])
    found = [(run.data.params["axis.a _b_"], run.data.params["axis.a _b__"]) for run in runs]
    assert sorted(found) == [("fine", "one"), ("fine", "two"), ("rough", "one"), ("rough", "two")]


@pytest.mark.filterwarnings("default")  # of MLflow itself
def test_a_refusal_is_told_apart_from_a_server_that_does_not_answer(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tracking = pytest.importorskip("mlflow.tracking")
    exceptions = importlib.import_module("mlflow.exceptions")
    codes = importlib.import_module("mlflow.protos.databricks_pb2")

    def refuse(*args: object) -> None:
        raise exceptions.MlflowException("too large", codes.INVALID_PARAMETER_VALUE)

    def fall_silent(*args: object) -> None:
        raise exceptions.MlflowException("API request failed")

    uri = (folder.parent / "store").as_uri()
    client: Any = tracking.MlflowClient(uri)
    for answer, message in [
        (refuse, f"MLflow at {uri} refuses this study: too large\n  change that there, and export again"),
        (fall_silent, f"MLflow at {uri}: API request failed\n  set MLFLOW_TRACKING_URI to a server that answers"),
    ]:
        monkeypatch.setattr(tracking.MlflowClient, "log_artifact", answer)
        assert main(["ablate", "--report", "out", "--export", "mlflow"]) == 2
        assert capsys.readouterr().err.strip() == message
    runs = client.search_runs([client.get_experiment_by_name("toy").experiment_id])
    assert [run.info.status for run in runs] == ["FAILED", "FAILED"]
