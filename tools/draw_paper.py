"""Draw the pictures of ``docs/explanation/method.md``: the paper's Figs. 2, 3 and 8 of our runs, in 256 colours."""

from __future__ import annotations

import subprocess
import sysconfig
import tempfile
from pathlib import Path
from typing import NamedTuple

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
GRAPHNAV = str(Path(sysconfig.get_path("scripts")) / "graphnav")
TARGET = ROOT / "docs" / "explanation"
_COLOURS = 256


class Drawn(NamedTuple):
    """A file of ``docs/explanation`` and the words after ``graphnav figure RUN`` that draw it as ``written``."""

    file: str
    words: str
    written: str


RUNS = {
    "approach --seed 2 --set components+=score.components": (
        Drawn("paper-approach.png", "--separation --at 4.2s --at 4.6s --at 4.9s --at 5.2s --at 5.5s", "separation.png"),
        Drawn("paper-norms.png", "--at 4.9s", "norms_4.90s.png"),
    ),
    "paper_literal_approach --seed 1": (
        Drawn("paper-approach-literal.png", "--separation --at 6s --at 6.4s --at 7.2s --at 7.8s", "separation.png"),
        Drawn("paper-norms-literal.png", "--at 6.4s", "norms_6.40s.png"),
    ),
    "paper_literal_ccw --seed 1 --until 7": (Drawn("paper-components.png", "--at 6s", "components_6.00s.png"),),
}


def draw(target: Path) -> None:
    """Make every run, and draw its pictures into ``target``."""
    for run, pictures in RUNS.items():
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch) / "run"
            graphnav("run", *run.split(), "--no-tap", "--no-pictures", "-o", str(folder))
            for picture in pictures:
                graphnav("figure", str(folder), *picture.words.split(), "-o", scratch)
                save_small(Path(scratch) / picture.written, target / picture.file)


def graphnav(*words: str) -> None:
    """Run a command of graphnav; raises CalledProcessError if it fails."""
    subprocess.run([GRAPHNAV, *words], check=True)


def save_small(source: Path, target: Path) -> None:
    """Save a picture in 256 colours, a quarter of the size."""
    with Image.open(source) as picture:
        small = picture.convert("RGB").quantize(_COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        small.save(target, optimize=True)


if __name__ == "__main__":
    draw(TARGET)
