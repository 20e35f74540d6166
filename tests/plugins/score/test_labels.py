"""Labels drawn by hand on pictures of a recorded drive."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
from graphnav_score.labels import Labels

import graphnav
from graphnav import Plane, Stamp, Truth
from graphnav.core.cli import main
from graphnav.core.errors import UserError

STEP = 4


def write(file: Path, label: np.ndarray) -> None:
    PIL.Image.fromarray(label.astype(np.uint8)).save(file)


def a_plane(score: np.ndarray, valid: np.ndarray | None = None) -> Plane:
    cells = score.astype(np.float32)
    judged = np.ones(cells.shape, np.uint8) if valid is None else valid.astype(np.uint8)
    obstacle = ((cells > 0) & (judged != 0)).astype(np.uint8)
    return Plane(obstacle, cells, judged, STEP, float(obstacle.mean()))


def test_labelled_pixels_of_judged_cells_count(tmp_path: Path) -> None:
    label = np.full((8, 12), 128)
    label[:4, :4], label[4:] = 255, 0
    write(tmp_path / "100.png", label)
    write(tmp_path / "900.png", label)
    score = Labels(path=tmp_path)
    score.check()
    score.reset(0)
    cells = np.array([[2.0, 9.0, 9.0], [-1.0, 1.0, -1.0]])
    score.step(a_plane(cells, np.array([[1, 1, 1], [1, 1, 0]])), Stamp(100))
    score.step(a_plane(cells), Stamp(200))
    found = score.summary()
    assert found["frames"] == 1.0
    assert found["unmet_labels"] == 1.0
    assert found["judged_ratio"] == pytest.approx(48 / 64)
    assert found["auroc"] == pytest.approx(1.0, abs=1e-3)
    assert found["row_auroc"] == pytest.approx(1.0, abs=1e-3)
    assert found["balanced_accuracy_ratio"] == pytest.approx(0.75)


def test_names_may_count_from_elsewhere_and_nothing_is_made_up(tmp_path: Path) -> None:
    write(tmp_path / "5000100.png", np.zeros((8, 12)))
    score = Labels(path=tmp_path, start_us=5_000_000)
    score.reset(0)
    score.step(a_plane(np.zeros((2, 3))), Stamp(100))
    assert dict(score.summary()) == {"frames": 1.0, "unmet_labels": 0.0, "judged_ratio": 1.0}


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("a.txt", b"", "there is no PNG file in"),
        ("frame_1.png", b"", "is not named by a time in microseconds"),
        ("1.png", b"\x89PNG", "cannot be read as a PNG picture"),
    ],
)
def test_folders_that_are_no_labels_are_refused(tmp_path: Path, name: str, data: bytes, said: str) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(graphnav.ParamError, match=said):
        Labels(path=tmp_path).check()


def test_a_label_of_another_size_ends_the_run(tmp_path: Path) -> None:
    write(tmp_path / "100.png", np.zeros((9, 12)))
    score = Labels(path=tmp_path)
    score.reset(0)
    with pytest.raises(ValueError, match=r"has 12x9 pixels, which do not fit the 3x2 cells of 4 px"):
        score.step(a_plane(np.zeros((2, 3))), Stamp(100))


def test_a_drive_that_is_labelled_with_the_truth_scores_as_the_truth_does(tmp_path: Path) -> None:
    """The way of a drive of one's own: pictures out of the log, labels beside them, scored open loop by others."""
    drive, labels, frames = (tmp_path / name for name in ("drive", "labels", "frames"))
    labels.mkdir()
    run = graphnav.run("corridor_ccw", until_s=4, seed=3, folder=drive, pictures=False, record="all")
    assert main(["export", str(drive), "--to", "images", "--channel", "robot.image", "-o", str(frames)]) == 0
    wanted = list(run.log.messages("robot.truth"))[20::10]
    for time_s, truth in wanted:
        assert isinstance(truth, Truth)
        write(labels / f"{round(time_s * 1e6)}.png", 255 * (truth.obstacle != 0))
    first = min(int(file.stem) for file in frames.iterdir())
    graph = tmp_path / "labelled.yaml"
    graph.write_text(
        f"stages:\n  drive: {{use: io.recording, with: {{path: {frames}}}}}\n"
        "  flow: {use: flow.lucas_kanade, in: {image: drive.image}}\n"
        "  plane: {use: plane.homography, in: {flow: flow.flow}}\n"
        f"  labels: {{use: score.labels, with: {{path: {labels}, start_us: {first}}}, in: {{plane: plane.plane}}}}\n"
    )
    graphnav.run(graph, folder=tmp_path / "seen", pictures=False)
    found = json.loads((tmp_path / "seen" / "summary.json").read_text())["scores"]["labels"]
    assert found["frames"] == len(wanted)
    assert found["unmet_labels"] == 0.0
    assert found["auroc"] > 0.8
    (labels / "first.png").touch()
    with pytest.raises(UserError, match="is not named by a time"):
        graphnav.run(graph, folder=tmp_path / "again", pictures=False)
