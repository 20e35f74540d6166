"""Properties that every simulated camera must have with its optics, as functions of the simulator."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from graphnav_io.prepare import Prepare
from graphnav_world.rendering.camera import Camera
from graphnav_world.world import CameraWorld, WorldOutputs

from graphnav import Image, Latest, Stamp, Twist
from graphnav.arrays import Bools, Bytes, Doubles, Ints

World = Callable[..., CameraWorld]
TICK_S = 0.1
STANDING = Twist(v_mps=0.0, omega_radps=0.0)
POST = """
start: {at_m: [0, 0], heading_deg: 0}
obstacles:
  - {box: {center_m: [1.6, 0.3], size_m: [0.2, 0.2], turn_deg: 45}, height_m: 2}
"""


def last(make: World, map_file: Path, twist: Twist = STANDING, ticks: int = 3, **params: Any) -> WorldOutputs:
    """Return the outputs at the end of a drive by one command, without noise unless it is asked for."""
    world = make(map=map_file, **{"noise_sigma_gray": 0.0, "truth": True} | params)
    world.reset(3)
    outputs = [world.step(Latest(twist, TICK_S), Stamp(round(k * TICK_S * 1e6))) for k in range(ticks)]
    world.close()
    return outputs[-1]


def lean_errors_px(make: World, folder: Path) -> Doubles:
    """Return how far the edges of an upright post are from where a rolling shutter must show them, (edges and rows,).

    The camera looks level and turns on the spot, so that a point at x of the picture moves by f omega (1 + (x / f)^2)
    in a second, and a row is read later by its share of the readout.
    """
    map_file, readout_s = folder / "post.yaml", 0.08
    map_file.write_text(POST, encoding="utf-8")
    shown = [
        last(make, map_file, Twist(0.0, 1.5), ticks=5, tilt_deg=1.0, shutter_s=one_s) for one_s in (0.0, readout_s)
    ]
    still, rolling = (one.truth.obstacle.astype(bool) for one in shown if one.truth is not None)
    state = shown[0].state
    camera = Camera(tilt_deg=1.0)
    rows = np.flatnonzero(still.any(axis=1) & rolling.any(axis=1))
    assert len(rows) > 80, "the post is seen in most rows"
    after_s = readout_s * (rows - (camera.rows - 1) / 2) / (camera.rows - 1)
    errors = []
    for mirrored in (False, True):
        at, leaning = (_first_column(mask[rows], mirrored=mirrored) for mask in (still, rolling))
        from_axis = (at - camera.center_px[0]) / camera.focal_px
        moved_px = camera.focal_px * state.omega_radps * after_s * (1 + from_axis**2)
        assert np.ptp(moved_px) > 8.0
        errors.append(leaning - at - moved_px)
    return np.concatenate(errors)


def _first_column(mask: Bools, *, mirrored: bool) -> Ints:
    """Return the first column of each row in a mask, or the last one."""
    first: Ints = (mask[:, ::-1] if mirrored else mask).argmax(axis=1)
    return mask.shape[1] - 1 - first if mirrored else first


def standing_pictures(make: World, map_file: Path, **optics: Any) -> list[bytes]:
    """Return picture and truth of a robot that stands, as bytes, without and with some optics."""
    found = []
    for params in ({}, optics):
        outputs = last(make, map_file, noise_sigma_gray=2.0, **params)
        assert outputs.truth is not None
        of_truth = (outputs.truth.obstacle, outputs.truth.depth_m, outputs.truth.flow_px)
        found.append(b"".join(one.tobytes() for one in (outputs.image.pixels, *of_truth)))
    return found


def undistorted(make: World, map_file: Path, folder: Path, distortion: tuple[float, float]) -> dict[str, Bytes]:
    """Return the picture of a pinhole, of a lens, and that one as `io.prepare` undistorts it."""
    camera = Camera()
    (cx, cy), f = camera.center_px, camera.focal_px
    file = cv2.FileStorage(str(folder / "calibration.yaml"), cv2.FILE_STORAGE_WRITE)
    file.write("image_width", camera.cols)
    file.write("image_height", camera.rows)
    file.write("camera_matrix", np.array([[f, 0.0, cx], [0.0, f, cy], [0.0, 0.0, 1.0]]))
    file.write("distortion_coefficients", np.array([[*distortion, 0.0, 0.0, 0.0]]))
    file.release()
    prepare = Prepare(calibration=folder / "calibration.yaml")
    prepare.reset(0)
    pinhole, lens = (
        last(make, map_file, Twist(0.2, 0.4), distortion=one).image.pixels for one in ((0.0, 0.0), distortion)
    )
    return {"pinhole": pinhole, "lens": lens, "prepared": prepare.step(Image(pixels=lens)).pixels}


def smoothed(picture: Bytes) -> Doubles:
    """Return a picture without what interpolation blurs."""
    return np.asarray(cv2.GaussianBlur(picture.astype(np.float64), (0, 0), 1.5), np.float64)


def unprepared_gray(found: dict[str, Bytes]) -> tuple[float, float]:
    """Return how far from the pinhole's picture that of the lens is, as it is and prepared, where it shows anything."""
    seen = cv2.erode((found["prepared"] > 0).astype(np.uint8), np.ones((9, 9))) == 1
    assert seen.mean() > 0.75
    pinhole, lens, prepared = (smoothed(found[name])[seen] for name in ("pinhole", "lens", "prepared"))
    return float(np.abs(lens - pinhole).mean()), float(np.abs(prepared - pinhole).mean())
