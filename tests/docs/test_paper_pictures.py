"""The remade figures of the paper: the page names the commands that the tool draws them by."""

from __future__ import annotations

from pathlib import Path

import draw_paper
import numpy as np
import pytest
from PIL import Image

_PAGE = (draw_paper.TARGET / "method.md").read_text()
_MAX_BYTES = 200_000


@pytest.mark.parametrize(("run", "picture"), [(run, one) for run, of in draw_paper.RUNS.items() for one in of])
def test_each_picture_stands_after_its_commands_and_is_small(run: str, picture: draw_paper.Drawn) -> None:
    words = f"`graphnav run {run}`, then `graphnav figure RUN {picture.words}`"
    assert words in _PAGE
    assert f"]({picture.file})" in _PAGE.partition(words)[2].partition("graphnav run")[0]
    assert (draw_paper.TARGET / picture.file).stat().st_size < _MAX_BYTES


def test_every_picture_of_the_paper_is_drawn_by_the_tool() -> None:
    drawn = {picture.file for pictures in draw_paper.RUNS.values() for picture in pictures}
    assert {path.name for path in draw_paper.TARGET.glob("paper-*.png")} == drawn


def test_256_colours_stay_near_the_picture(tmp_path: Path) -> None:
    gray = np.tile(np.arange(256, dtype=np.uint8), (64, 1))
    picture = np.stack([gray, gray, gray], axis=-1)
    Image.fromarray(picture).save(tmp_path / "large.png")
    draw_paper.save_small(tmp_path / "large.png", tmp_path / "small.png")
    with Image.open(tmp_path / "small.png") as small:
        assert small.mode == "P"
        assert np.abs(np.asarray(small.convert("RGB"), int) - picture).max() <= 8
