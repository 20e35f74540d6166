"""How well a detector tells obstacle from ground in frames that were labelled by hand."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

import numpy as np
import PIL.Image

import graphnav
from graphnav import Metric, ParamError, Role, Stage, Stamp, block_sum, param, read_regular
from graphnav.arrays import Bytes, Floats
from graphnav_score.detection import (
    AUROC,
    BALANCED_ACCURACY,
    FALSE_ALARM_RATIO,
    RECALL,
    balanced_accuracy,
    judged_ratio,
    share,
)
from graphnav_score.frame_metrics import of_frames
from graphnav_score.roc import Roc

GROUND, OBSTACLE = 0, 255
"""Gray levels of labels; what has another one is not labelled."""
MAX_BYTES = 64 * 1024**2
FORM = "name labels by the times of their pictures in microseconds, as 'graphnav export --to images' does: 1200000.png"
_DRAW = "draw them on the pictures that 'graphnav export --to images' writes, at their size: 255 obstacle, 0 ground"


class Labels(Stage):
    """How well a detector tells obstacle from ground in frames that were labelled by hand.

    ``path`` holds a gray PNG file for each labelled picture, of its size and named by its time in microseconds: 255 is
    obstacle, 0 ground, any other level is not labelled. Every cell speaks for its labelled pixels, and the pixels of
    all labelled frames are pooled. ``row_auroc`` is what the row alone says, without any detector: the higher,
    the more obstacle. A detector that is no better tells nothing beyond where the camera looks.

    A metric that is not defined (no label met, no obstacle, no ground) is left out.
    """

    role: ClassVar[Role] = "score"
    metrics: ClassVar[tuple[Metric, ...]] = of_frames(
        Metric("frames", better="neither", bounds=(0.0, None), help="Labelled frames that were met."),
        Metric("unmet_labels", better="neither", bounds=(0.0, None), help="Labels at whose times no frame came."),
        judged_ratio("the labelled pixels"),
        AUROC,
        Metric(
            "row_auroc",
            better="neither",
            bounds=(0.0, 1.0),
            is_key=True,
            help="The same of the picture's row in place of the score, on the same pixels.",
        ),
        RECALL,
        BALANCED_ACCURACY,
    )

    path: Path = param(doc="a folder of labels, gray PNG files named by the times of their pictures in microseconds")
    start_us: int = param(
        0, ge=0, doc="time of the first picture where names count from elsewhere, as those that `io.recording` reads"
    )

    def check(self) -> None:
        """Check that there are labels and that the first one can be read."""
        files = self._find()
        try:
            _read(files[min(files)])
        except ValueError as error:
            raise ParamError("path", str(error), _DRAW) from error

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Begin without any frame."""
        self._files = self._find()
        self._roc, self._row_roc = Roc(), Roc()
        self._frames, self._labelled = 0, 0.0
        # Pixels of ground and of obstacle (rows) that were called ground and called obstacle.
        self._confusion = np.zeros((2, 2))

    def step(self, plane: graphnav.Plane, stamp: Stamp) -> None:
        """Count this frame if it is labelled.

        Raises
        ------
        ValueError
            A label cannot be read, or has another size than its picture.
        """
        file = self._files.pop(int(stamp) + self.start_us, None)
        if file is None:
            return
        pixels = _pixels(_read(file), plane, file)
        judged = plane.valid != 0
        ground, obstacle = (kind[judged].astype(np.float64) for kind in pixels)
        self._roc.add(plane.score[judged], obstacle, ground)
        row = np.broadcast_to(-np.arange(judged.shape[0], dtype=np.float32)[:, None], judged.shape)
        self._row_roc.add(row[judged], obstacle, ground)
        called = plane.obstacle[judged] != 0
        self._confusion += [[kind[~called].sum(), kind[called].sum()] for kind in (ground, obstacle)]
        self._labelled += float(pixels.sum())
        self._frames += 1

    def summary(self) -> Mapping[str, float]:
        """Return the metrics that are defined."""
        (kept, false), (missed, hit) = self._confusion.tolist()
        values = {
            "judged_ratio": share(self._confusion.sum(), self._labelled),
            "auroc": self._roc.area(),
            "row_auroc": self._row_roc.area(),
            "recall_at_5_false_alarms_ratio": self._roc.recall(FALSE_ALARM_RATIO),
            "balanced_accuracy_ratio": balanced_accuracy(kept, false, missed, hit),
        }
        met = {"frames": float(self._frames), "unmet_labels": float(len(self._files))}
        return met | {name: value for name, value in values.items() if value is not None}

    def _find(self) -> dict[int, Path]:
        """Return the files of labels by their times in microseconds."""
        try:
            files = sorted(file for file in self.path.iterdir() if file.suffix.lower() == ".png")
        except OSError as error:
            raise ParamError("path", f"'{self.path}' cannot be read: {error.strerror}", "give a folder") from error
        if not files:
            raise ParamError("path", f"there is no PNG file in '{self.path}'", _DRAW)
        for file in files:
            if not (file.stem.isascii() and file.stem.isdecimal()):
                raise ParamError("path", f"'{file}' is not named by a time in microseconds", FORM)
        return {int(file.stem): file for file in files}


def _read(file: Path) -> Bytes:
    """Return a label, uint8 (rows, cols); raises ValueError."""
    try:
        with PIL.Image.open(io.BytesIO(read_regular(file, MAX_BYTES)), formats=["PNG"]) as picture:
            return np.asarray(picture.convert("L"), np.uint8)
    except (OSError, ValueError, SyntaxError, PIL.Image.DecompressionBombError) as error:
        raise ValueError(f"'{file}' cannot be read as a PNG picture: {error}") from error


def _pixels(label: Bytes, plane: graphnav.Plane, file: Path) -> Floats:
    """Return how many pixels of each cell are labelled ground and obstacle, (2, rows, cols)."""
    step = plane.step_px
    rows, cols = label.shape
    wanted = plane.obstacle.shape
    if (-(-rows // step), -(-cols // step)) != wanted:
        cells = f"the {wanted[1]}x{wanted[0]} cells of {step} px"
        raise ValueError(f"'{file}' has {cols}x{rows} pixels, which do not fit {cells}; {_DRAW}")
    return np.stack([block_sum((label == kind).astype(np.float32), step) for kind in (GROUND, OBSTACLE)])
