"""Measure flows and detectors on real forward cameras: ``python tools/real_video.py DATA``.

DATA holds the folders ``udacity_road`` (a highway, 960x540, 25 Hz; GitHub udacity/CarND-LaneLines-P1) and
``donkeycar_carpet`` (a small robot on a carpet, 160x120, 20 Hz; GitHub yuki-shimoda-crypto/Donkey_Car). The labels are
drawn by hand, in ``real_video_labels.json``: 6 road frames with their cars, 15 carpet frames with the foot of the
walls.

Prints two tables for each data set, of the AUROC of obstacle against ground on the cells that are judged, as means over
frames. The first compares flows. The second takes apart what the graph ``video_plane`` does: cropping, scores relative
to the flow's length, and `plane.prior` behind it, with 95 % intervals from resampled frames. The prior has its default
weight of the detector, which was chosen in simulation (``tools/forward_camera.yaml``); what others give is printed
below. A frame without labelled obstacle below the crop counts in neither.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from graphnav_flow.dis import Dis
from graphnav_flow.farneback import Farneback
from graphnav_flow.lucas_kanade import LucasKanade
from graphnav_plane.affine import Affine
from graphnav_plane.homography import Homography
from graphnav_plane.prior import Prior
from graphnav_plane.row_prior import RowPrior
from scipy.stats import rankdata
from testbed.flows import flow_from

from graphnav import Flow, Image, Plane, Stage, Stamp
from graphnav.arrays import Bools, Bytes, Doubles, Floats
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph, shipped_graphs

LABELS = json.loads(Path(__file__).with_name("real_video_labels.json").read_text(encoding="utf-8"))
PERIOD_US = 40_000
BEFORE_FRAMES = 4
"""Frames that a detector sees before the labelled one, for its memory."""
BORDER_PX = 2
"""Pixels beside a drawn line that count as neither."""
MIN_TEXTURE_GRAY2 = 0.5
MAX_DEVIATION_PX = 100.0
"""As in `video_plane`: of compressed pictures the default would judge one cell in six or fewer."""
FIT_PX = 0.5
"""Residual up to which a vector agrees with the ground's motion."""

WEIGHTS = (0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0, 1.5)
"""Of the detector in the prior."""
HORIZONS = (0.1, 0.25, 0.4)
"""Values of ``horizon_ratio``, by which the map changes and the AUROC does not."""
RESAMPLED = 10_000

Flows = Sequence[tuple[Flow, Stamp]]
"""Of the pictures of a case with their stamps, the labelled frame last."""
Cells = tuple[Bools, Bools]
"""Which cells are obstacle, and which are ground."""


@dataclass(frozen=True)
class Labelled:
    """A labelled frame with the frames before it, and the labels of its pixels."""

    frames: Sequence[Bytes]
    obstacle: Bytes
    ground: Bytes
    layers: int

    def row(self, crop_ratio: float) -> int:
        """Return the first row that a crop of the top keeps."""
        return round(crop_ratio * len(self.obstacle))


def flows(layers: int) -> dict[str, Stage]:
    """Return the compared estimators."""
    usual: dict[str, Any] = {"min_texture_gray2": MIN_TEXTURE_GRAY2}
    ours = partial(LucasKanade, layers=layers, max_deviation_px=MAX_DEVIATION_PX, **usual)
    return {
        "Lucas-Kanade": ours(normalize_sigma_px=None),
        "Lucas-Kanade, normalized": ours(light_ratio=0.0),
        "  and checked backward": ours(light_ratio=0.0, max_disagreement_px=1.0),
        "  window of 17 px": ours(light_ratio=0.0, window_radius_px=8),
        "  and judged by deviation": LucasKanade(layers=layers, light_ratio=0.0, window_radius_px=8, **usual),
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
        else:
            _fill(ground, [(x, y + BORDER_PX) for x, y in drawn], rows - 1)
            _fill(obstacle, [(x, y - BORDER_PX) for x, y in drawn], 0)
        last = int(number)
        yield Labelled(pictures[last - BEFORE_FRAMES : last + 1], obstacle, ground, about["layers"])


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


def flows_of(case: Labelled, stage: Stage, crop_ratio: float) -> Flows:
    """Return the flows of the pictures of a case without the rows that are cropped."""
    stage.reset(0)
    found = []
    for k, picture in enumerate(case.frames):
        stamp = Stamp(k * PERIOD_US)
        flow = flow_from(stage, Image(pixels=np.ascontiguousarray(picture[case.row(crop_ratio) :])), stamp)
        if flow is not None:
            found.append((flow, stamp))
    return found


def plane_of(flows: Flows, detector: Stage) -> Plane:
    """Return the plane of the last of the flows."""
    detector.reset(0)
    plane: Plane
    for flow, stamp in flows:
        given = (flow,) if isinstance(detector, RowPrior) else (flow, stamp)
        plane = detector.step(*given)  # type: ignore[attr-defined]
    return plane


def cell_labels(case: Labelled, plane: Plane, row: int) -> Cells:
    """Return the cells that are obstacle or ground to at least three quarters; ``row``: the plane's first."""
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


def measured(case: Labelled, plane: Plane, crop_ratio: float, from_ratio: float = 0.0) -> tuple[float, float]:
    """Return the AUROC and the share of labelled cells that are judged, of a plane of the cropped picture.

    ``from_ratio``: cells above this share of the picture's rows count in neither.
    """
    row = case.row(crop_ratio)
    obstacle, ground = cell_labels(case, plane, row)
    counts = (row + plane.step_px * (np.arange(len(plane.valid)) + 0.5) >= case.row(from_ratio))[:, None]
    labelled_cells, valid = (obstacle | ground) & counts, (plane.valid != 0) & counts
    share = np.count_nonzero(labelled_cells & valid) / max(int(np.count_nonzero(labelled_cells)), 1)
    return auroc(plane.score[obstacle & valid], plane.score[ground & valid]), share


def marked_of(case: Labelled, plane: Plane, crop_ratio: float) -> tuple[float, float]:
    """Return the shares of the judged cells of obstacle and of ground that the map calls obstacle."""
    obstacle, ground = (cells & (plane.valid != 0) for cells in cell_labels(case, plane, case.row(crop_ratio)))
    return float(plane.obstacle[obstacle].mean()) if obstacle.any() else np.nan, float(plane.obstacle[ground].mean())


def interval(values: Doubles) -> tuple[float, float, float]:
    """Return the mean and its 95 % interval, by resampling the frames that have a value; they are not independent."""
    known = values[np.isfinite(values)]
    if not known.size:
        return (float("nan"),) * 3
    drawn = np.random.default_rng(0).integers(0, known.size, (RESAMPLED, known.size))
    low, high = np.percentile(known[drawn].mean(axis=1), [2.5, 97.5])
    return float(known.mean()), float(low), float(high)


def compare_flows(cases: Sequence[Labelled], crop_ratio: float) -> None:
    """Print the AUROC of the detectors on each flow."""
    fit: dict[str, Any] = {"threshold_px": FIT_PX}
    detectors = (
        Homography(**fit),
        Homography(**fit, threshold_ratio=0.0),
        Affine(**fit),
        Affine(**fit, threshold_ratio=0.0),
        RowPrior(),
    )
    print(f"  {'flow':28} homography  / length  affine  / length  row prior  judged")
    for name, stage in flows(cases[0].layers).items():
        found = [flows_of(case, stage, crop_ratio) for case in cases]
        table = np.array(
            [
                [measured(case, plane_of(seen, one), crop_ratio) for one in detectors]
                for case, seen in zip(cases, found, strict=True)
            ]
        )
        mean = np.nanmean(table, axis=0)
        print(f"  {name:28} " + "  ".join(f"{value:.3f}" for value in [*mean[:, 0], mean[-1, 1]]))


def video_plane(stage: str) -> dict[str, Any]:
    """Return the parameters of a stage of the graph."""
    graph = load_graph(shipped_graphs()["video_plane"], Catalog())
    (node,) = (node for node in graph.nodes if node.name == stage)
    return dict(node.params)


def compare_parts(cases: Sequence[Labelled], stage: Stage, crop_ratio: float) -> None:
    """Print what each part of the graph gives, and its difference from the row prior alone in the same frames."""
    fit = video_plane("plane")
    relative, pixels = Homography(**fit), Homography(**fit | {"threshold_ratio": None})
    cropped = [flows_of(case, stage, crop_ratio) for case in cases]
    planes = [plane_of(seen, relative) for seen in cropped]

    def column(found: Iterable[Plane], crop: float = crop_ratio) -> Doubles:
        return np.array([measured(case, one, crop, crop_ratio)[0] for case, one in zip(cases, found, strict=True)])

    rows = column(plane_of(seen, RowPrior()) for seen in cropped)
    made: dict[str, Doubles] = {}
    if crop_ratio:
        full = [flows_of(case, stage, 0.0) for case in cases]
        made["full picture, scored below"] = column((plane_of(seen, pixels) for seen in full), 0.0)
        made["  / length"] = column((plane_of(seen, relative) for seen in full), 0.0)
    made["homography"] = column(plane_of(seen, pixels) for seen in cropped)
    made["homography / length"] = column(planes)
    made["row prior"] = rows
    made["row prior with homography / length"] = column(map(Prior().step, planes))
    for name, values in made.items():
        mean, low, high = interval(values)
        difference = "{:+.3f} [{:+.3f}, {:+.3f}]".format(*interval(values - rows))
        print(f"  {name:34} {mean:.3f} [{low:.3f}, {high:.3f}]  minus row prior {difference}")
    by_weight = {weight: column(map(Prior(detector_weight=weight).step, planes)) for weight in WEIGHTS}
    told = "  ".join(f"{weight:g}: {np.nanmean(values):.3f}" for weight, values in by_weight.items())
    print(f"  {np.isfinite(rows).sum()} frames; by weight of the homography {told}")
    maps = {"homography / length": planes}
    for ratio in HORIZONS:
        maps[f"the last, horizon_ratio {ratio:g}"] = [Prior(horizon_ratio=ratio).step(plane) for plane in planes]
    for title, mapped in maps.items():
        marked = [marked_of(case, one, crop_ratio) for case, one in zip(cases, mapped, strict=True)]
        recall, false = np.nanmean(np.array(marked), axis=0).tolist()
        print(f"  map of {title}: {recall:.0%} of the obstacle, {false:.0%} of the ground")


def main(data: str) -> None:
    """Print the tables."""
    cv2.setNumThreads(1)
    crop_ratio = video_plane("camera")["crop_top_ratio"]
    sets = {name: list(labelled(Path(data), name)) for name in LABELS}
    for name, cases in sets.items():
        for crop in (0.0, crop_ratio):
            print(f"{name}, {len(cases)} frames, {crop:.0%} cropped")
            compare_flows(cases, crop)
    stages = {
        "flow of video_plane": LucasKanade(**video_plane("flow")),
        "Farneback, window of 31 px": Farneback(window_px=31, min_texture_gray2=MIN_TEXTURE_GRAY2),
    }
    for name, cases in sets.items():
        for flow_name, stage in stages.items():
            for crop in (0.0, crop_ratio / 2, crop_ratio):
                print(f"{name}, {flow_name}, {crop:.0%} cropped")
                compare_parts(cases, stage, crop)


if __name__ == "__main__":
    main(*sys.argv[1:])
