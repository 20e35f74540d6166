"""The pictures of the separation and of several frames in rows, of a short real run."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from graphnav_view.panels.separation_page import mixture

from graphnav import Components, Recording
from graphnav.core.cli import main
from graphnav.core.run_folder import RunFolder


@pytest.fixture(scope="module")
def literal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a second of driving as the paper prints it."""
    folder = tmp_path_factory.mktemp("literal") / "run"
    words = ["--until", "1", "--no-pictures", "--no-tap"]
    assert main(["run", "paper_literal_approach", *words, "-o", str(folder)]) == 0
    return folder


def test_a_run_with_components_has_a_picture_of_them(
    literal: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["figure", str(literal), "-o", str(tmp_path)]) == 0
    assert str(tmp_path / "components.png") in capsys.readouterr().out.split()


def test_a_frame_with_components_has_two_more_pictures(
    literal: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["figure", str(literal), "--at", "0.5s", "-o", str(tmp_path)]) == 0
    written = capsys.readouterr().out.split()
    assert written == [str(tmp_path / f"{name}_0.50s.png") for name in ("panels", "components", "norms")]


def test_the_mixtures_are_drawn_from_the_components(literal: Path) -> None:
    with Recording(literal / RunFolder.LOG) as log:
        components = log.message("plane.components", -1)[2]
        assert isinstance(components, Components)
        for row, name in enumerate(("flow.flow", "planar.planar")):
            message = log.message(name, -1)[2]
            field = getattr(message, "uv_px" if row == 0 else "planar_uv_px")
            valid = components.valid != 0
            assert mixture(components, row)[valid] == pytest.approx(field[valid], abs=1e-4)


def test_rows_are_one_picture_that_grows_with_the_frames(literal: Path, tmp_path: Path) -> None:
    heights = []
    for times in (["0.3s"], ["0.3s", "0.6s"], ["0.6s", "0.3s", "0.9s"]):
        words = [word for time in times for word in ("--at", time)]
        assert main(["figure", str(literal), "--rows", *words, "-o", str(tmp_path)]) == 0
        picture = cv2.imread(str(tmp_path / "rows.png"))
        assert picture is not None
        heights.append(picture.shape[0])
    first, second = np.diff(heights)
    assert first == pytest.approx(second, abs=1)
    assert first == pytest.approx(120 * (0.32 + 2.0 * 0.75), abs=2)


def test_rows_need_times_and_not_too_many(literal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["figure", str(literal), "--rows"]) == 2
    assert "add --at 2s --at 4s" in capsys.readouterr().err
    assert main(["figure", str(literal), "--rows", "--at", "99s"]) == 2
    assert "no frame at 99 s" in capsys.readouterr().err
