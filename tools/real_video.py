"""Measure flows and detectors on real forward cameras: ``python tools/real_video.py DATA``.

DATA holds the folders ``udacity_road`` (a highway, 960x540, 25 Hz; GitHub udacity/CarND-LaneLines-P1) and
``donkeycar_carpet`` (a small robot on a carpet, 160x120, 20 Hz; GitHub yuki-shimoda-crypto/Donkey_Car). The labels are
drawn by hand, in ``real_video_labels.json``: 6 road frames with their cars, 15 carpet frames with the foot of the
walls.
Prints the mean over frames of the AUROC of obstacle against ground on the cells that are judged, and the share of the
labelled cells that are. The flow's length is that at the cell, plus one pixel.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from graphnav_flow.dis import Dis
from graphnav_flow.farneback import Farneback
from graphnav_flow.lucas_kanade import LucasKanade
from graphnav_plane.affine import Affine
from graphnav_plane.homography import Homography
from graphnav_plane.row_prior import RowPrior
from scipy.stats import rankdata
from testbed.flows import flow_from

from graphnav import Flow, Image, Plane, Stage, Stamp, coarsen
from graphnav.arrays import Bools, Bytes, Doubles, Floats

LABELS = json.loads(Path(__file__).with_name("real_video_labels.json").read_text(encoding="utf-8"))
PERIOD_US = 40_000
BEFORE_FRAMES = 4
"""Frames that a detector sees before the labelled one, for its memory."""
BORDER_PX = 2
"""Pixels beside a drawn line that count as neither."""
MIN_TEXTURE_GRAY2 = 0.5

Cells = tuple[Bools, Bools]
"""Which cells are obstacle, and which are ground."""


@dataclass(frozen=True)
class Labelled:
    """A labelled frame with the frames before it, the labels of its pixels, and the first row below the sky."""

    frames: Sequence[Bytes]
    obstacle: Bytes
    ground: Bytes
    layers: int
    crop_row: int


def flows(layers: int) -> dict[str, Stage]:
    """Return the compared estimators."""
    usual: dict[str, Any] = {"min_texture_gray2": MIN_TEXTURE_GRAY2}
    return {
        "Lucas-Kanade": LucasKanade(layers=layers, normalize_sigma_px=None, **usual),
        "Lucas-Kanade, normalized": LucasKanade(layers=layers, light_ratio=0.0, **usual),
        "  and checked backward": LucasKanade(layers=layers, light_ratio=0.0, max_disagreement_px=1.0, **usual),
        "  window of 17 px": LucasKanade(layers=layers, light_ratio=0.0, window_radius_px=8, **usual),
        "DIS": Dis(**usual),
        "Farneback": Farneback(layers=layers, **usual),
        "Farneback, window of 31 px": Farneback(layers=layers, window_px=31, **usual),
    }


def labelled(data: Path, name: str) -> Iterator[Labelled]:
    """Yield the labelled frames of one of the sequences."""
    about = LABELS[name]
    cols, rows = about["size"]
    pictures = _road(data / name, (cols, rows)) if "ground" in about else _carpet(data / name)
    for number, drawn in about["frames"].items():
        obstacle, ground = np.zeros((2, rows, cols), np.uint8)
        if "ground" in about:
            _fill(ground, about["ground"], rows - 1)
            for left, top, right, bottom in drawn:
                obstacle[top:bottom, left:right] = 1
                ground[top - BORDER_PX : bottom + 3 * BORDER_PX, max(left - BORDER_PX, 0) : right + BORDER_PX] = 0
            crop_row = min(y for _, y in about["obstacle"])
        else:
            _fill(ground, [(x, y + BORDER_PX) for x, y in drawn], rows - 1)
            _fill(obstacle, [(x, y - BORDER_PX) for x, y in drawn], 0)
            crop_row = 0
        last = int(number)
        yield Labelled(pictures[last - BEFORE_FRAMES : last + 1], obstacle, ground, about["layers"], crop_row)


def _fill(mask: Bytes, line: Sequence[tuple[int, int]], to_row: int) -> None:
    (first, *_, last) = line
    corners = [*line, (last[0], to_row), (first[0], to_row)]
    cv2.fillPoly(mask, [np.array(corners, np.int32)], [1])


def _road(folder: Path, size: tuple[int, int]) -> list[Bytes]:
    capture, pictures = cv2.VideoCapture(str(folder / "solidWhiteRight.mp4")), []
    while (read := capture.read())[0]:
        pictures.append(cv2.resize(cv2.cvtColor(read[1], cv2.COLOR_BGR2GRAY), size, interpolation=cv2.INTER_AREA))
    return pictures


def _carpet(folder: Path) -> list[Bytes]:
    paths = sorted(folder.glob("*.jpg"))
    return [np.asarray(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), np.uint8) for path in paths]


def judged(case: Labelled, stage: Stage, detector: Stage, row: int) -> tuple[Plane, Flow]:
    """Return plane and flow of the labelled frame, both without the rows above ``row``."""
    stage.reset(0)
    detector.reset(0)
    for k, picture in enumerate(case.frames):
        stamp = Stamp(k * PERIOD_US)
        flow = flow_from(stage, Image(pixels=np.ascontiguousarray(picture[row:])), stamp)
        if flow is not None:
            given = (flow,) if isinstance(detector, RowPrior) else (flow, stamp)
            plane = detector.step(*given)  # type: ignore[attr-defined]
    return plane, flow


def cell_labels(case: Labelled, plane: Plane, row: int) -> Cells:
    """Return the cells that are obstacle or ground to at least three quarters."""
    step, (rows, cols) = plane.step_px, plane.valid.shape
    shares = []
    for mask in (case.obstacle, case.ground):
        part = mask[row : row + rows * step, : cols * step].astype(np.float32)
        shares.append(cv2.resize(part, (cols, rows), interpolation=cv2.INTER_AREA) > 0.75)
    return shares[0], shares[1]


def auroc(obstacle: Floats, ground: Floats) -> float:
    """Return the share of pairs in which the obstacle scores more; ties count half."""
    ranks = rankdata(np.concatenate([obstacle, ground]))
    n, m = len(obstacle), len(ground)
    return float((ranks[:n].sum() - n * (n + 1) / 2) / (n * m)) if n and m else float("nan")


def measure(cases: Sequence[Labelled], stage: Stage, detector: Stage, *, crop: bool, relative: bool) -> Doubles:
    """Return AUROC and share of judged cells of each case, (cases, 2)."""
    found = []
    for case in cases:
        row = case.crop_row if crop else 0
        plane, flow = judged(case, stage, detector, row)
        score = plane.score
        if relative:
            score = score / (np.linalg.norm(coarsen(flow, plane.step_px).uv_px, axis=-1) + 1)
        obstacle, ground = cell_labels(case, plane, row)
        valid = plane.valid != 0
        share = np.count_nonzero((obstacle | ground) & valid) / np.count_nonzero(obstacle | ground)
        found.append((auroc(score[obstacle & valid], score[ground & valid]), share))
    return np.array(found)


def main(data: str) -> None:
    """Print the table."""
    cv2.setNumThreads(1)
    detectors: dict[str, tuple[Callable[[], Stage], dict[str, bool]]] = {
        "homography": (lambda: Homography(threshold_px=0.5), {}),
        "homography / length": (lambda: Homography(threshold_px=0.5), {"relative": True}),
        "affine": (lambda: Affine(threshold_px=0.5), {}),
        "affine / length": (lambda: Affine(threshold_px=0.5), {"relative": True}),
    }
    for name in LABELS:
        cases = list(labelled(Path(data), name))
        for crop in (False, True) if cases[0].crop_row else (False,):
            print(f"{name}, {len(cases)} frames" + (", without the sky" if crop else ""))
            for flow_name, stage in flows(cases[0].layers).items():
                cells = []
                for detector, options in detectors.values():
                    values = measure(cases, stage, detector(), crop=crop, relative=options.get("relative", False))
                    cells.append(f"{np.nanmean(values[:, 0]):.3f}")
                prior = measure(cases, stage, RowPrior(), crop=crop, relative=False)
                cells += [f"{np.nanmean(prior[:, 0]):.3f}", f"{np.mean(prior[:, 1]):.2f}"]
                print(f"  {flow_name:28} " + "  ".join(cells))


if __name__ == "__main__":
    main(*sys.argv[1:])
