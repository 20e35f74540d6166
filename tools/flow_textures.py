"""Which flow follows which texture and displacement: ``python tools/flow_textures.py [CARPET]``.

Warps a picture by a known homography (a shift, with up to 3 % of zoom and 0.02 rad of rotation), adds noise of 1.5
gray, and prints two tables, 18 px from the border and more: the percentage of vectors that are off by more than a
pixel, valid or not, and the mean endpoint error of the valid ones, px, with their percentage. The pictures: a pattern
that repeats every so many pixels under irregular texture of 2 or 10 gray; the photographs of brick, gravel and grass of
scikit-image (``pip install "graphnav[photos]"``); and, where its folder is given, every 15th frame of
``donkeycar_carpet`` below row 30. What is real also 30 % brighter in the later frame.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from graphnav_flow.dis import Dis
from graphnav_flow.farneback import Farneback
from graphnav_flow.lucas_kanade import LucasKanade
from testbed.flows import flow_from

from graphnav import Image, Stage, Stamp, import_extra
from graphnav.arrays import Bytes, Doubles, Floats

ROWS, COLS = 120, 160
BORDER_PX = 18
PICTURES = 20
SHIFTS_PX = (2, 5, 10, 16)
Pair = tuple[Bytes, Bytes, Doubles]


def estimators() -> dict[str, Stage]:
    """Return the compared stages."""
    return {
        "Lucas-Kanade": LucasKanade(),
        "  always normalized": LucasKanade(light_ratio=0.0),
        "  window of 17 px": LucasKanade(window_radius_px=8),
        "  both": LucasKanade(light_ratio=0.0, window_radius_px=8),
        "  two layers": LucasKanade(layers=2),
        "Farneback": Farneback(),
        "Farneback, window of 31 px": Farneback(window_px=31),
        "DIS": Dis(),
    }


def pattern(seed: int, period_px: float, irregular_gray: float) -> Floats:
    """Return a picture of spots in rows and columns, turned at random, under irregular texture."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:ROWS, :COLS]
    turn = rng.uniform(0, np.pi)
    u, v = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    coarse = cv2.GaussianBlur(rng.standard_normal((ROWS, COLS)).astype(np.float32), (0, 0), 6)
    spots = np.sin(2 * np.pi * u / period_px) * np.sin(2 * np.pi * v / period_px)
    gray: Floats = (128 + 30 * spots + irregular_gray * coarse / coarse.std()).astype(np.float32)
    return gray


def warped(picture: Floats, seed: int, shift_px: float, light: float = 1.0) -> Pair:
    """Return two frames, and the displacement of what is at each pixel of the later one, (rows, cols, 2)."""
    rng = np.random.default_rng(seed)
    rows, cols = picture.shape
    turn, zoom, bearing = rng.uniform(-0.02, 0.02), 1 + rng.uniform(-0.03, 0.03), rng.uniform(0, 2 * np.pi)
    y, x = np.mgrid[:rows, :cols].astype(float)
    dx, dy = x - cols / 2, y - rows / 2
    source_x = cols / 2 + zoom * (np.cos(turn) * dx - np.sin(turn) * dy) + shift_px * np.cos(bearing)
    source_y = rows / 2 + zoom * (np.sin(turn) * dx + np.cos(turn) * dy) + shift_px * np.sin(bearing)
    maps = source_x.astype(np.float32), source_y.astype(np.float32)
    now = light * cv2.remap(picture, *maps, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
    before, later = (
        np.clip(np.rint(frame + 1.5 * rng.standard_normal(frame.shape)), 0, 255).astype(np.uint8)
        for frame in (picture, now)
    )
    return before, later, np.stack([x - source_x, y - source_y], -1)


def errors(stage: Stage, pairs: Sequence[Pair]) -> tuple[float, float, float]:
    """Return the percentage of vectors off by more than a pixel, the mean error of the valid ones, their percentage."""
    inner, errors_px, valid = np.s_[BORDER_PX:-BORDER_PX, BORDER_PX:-BORDER_PX], [], []
    for before, now, true_px in pairs:
        stage.reset(0)
        stage.step(Image(pixels=before), Stamp(0))  # type: ignore[attr-defined]
        flow = flow_from(stage, Image(pixels=now), Stamp(100_000))
        errors_px.append(np.linalg.norm(flow.uv_px - true_px, axis=-1)[inner])
        valid.append(flow.valid[inner] != 0)
    off_px, is_valid = np.array(errors_px), np.array(valid)
    mean_px = float(off_px[is_valid].mean()) if is_valid.any() else float("nan")
    return 100 * float(np.mean(off_px > 1)), mean_px, 100 * float(is_valid.mean())


def photographs() -> list[Floats]:
    """Return parts of scikit-image's photographs of brick, gravel and grass, in the size of the other pictures."""
    shown, data = [], import_extra("skimage.data", "photos", "tools/flow_textures.py", "scikit-image")
    for name in ("brick", "gravel", "grass"):
        photograph = np.asarray(getattr(data, name)(), np.float32)
        shown += [photograph[y : y + ROWS, x : x + COLS] for y in (0, 180, 360) for x in (0, 170, 340)]
    return shown


def main(carpet: str | None = None) -> None:
    """Print two tables for each kind of texture; a column a shift."""
    cv2.setNumThreads(1)
    pictures: dict[tuple[str, float], list[Floats]] = {
        (f"spots every {period_px} px, irregular texture of {gray} gray", 1.0): [
            pattern(seed, period_px, gray) for seed in range(PICTURES)
        ]
        for period_px in (6, 10)
        for gray in (2, 10)
    }
    real = {"brick, gravel and grass": photographs()}
    if carpet:
        paths = sorted(Path(carpet).glob("*.jpg"))[::15]
        real["carpet"] = [np.asarray(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), np.float32)[30:] for path in paths]
    for name, frames in real.items():
        pictures |= {(name, 1.0): frames, (f"{name}, 30 % brighter in the later frame", 1.3): frames}
    for (name, light), shown in pictures.items():
        print(f"{name}, at {', '.join(map(str, SHIFTS_PX))} px: % off by more than 1 px | error of valid, px (% valid)")
        sets = [[warped(frame, k, shift, light) for k, frame in enumerate(shown)] for shift in SHIFTS_PX]
        for stage_name, stage in estimators().items():
            off, error, valid = zip(*(errors(stage, pairs) for pairs in sets), strict=True)
            told = "  ".join(f"{mean:5.2f} ({share:3.0f})" for mean, share in zip(error, valid, strict=True))
            print(f"  {stage_name:28}", *(f"{share:6.1f}" for share in off), " | ", told)


if __name__ == "__main__":
    main(*sys.argv[1:])
