"""Benchmark rendering with truth, relative to OpenCV's Farneback on the same images in the same process."""

from __future__ import annotations

import itertools
import time
from dataclasses import dataclass

import cv2
import numpy as np
from graphnav_world.geometry import outlines
from graphnav_world.geometry.scene import Body, Faces, faces_of
from graphnav_world.rendering.atlas import Atlas, floor_texels
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.film import Film
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.render import Frame, Renderer
from graphnav_world.rendering.textures import Texture
from taking_turns import Ratio, load_told, take_turns, timed

from graphnav.arrays import Bytes


@dataclass(frozen=True)
class RenderCost:
    """Medians over the rounds, milliseconds of processor time, and the ratio."""

    faces: int
    render_ms: float
    farneback_ms: float
    ratio: Ratio


def bodies() -> list[Body]:
    """Return a corner of a corridor with boxes and pillars, walls crossing boxes; about 40 faces are in view."""
    around = np.array([0.4, 1.9])
    inner = np.concatenate([[[-1.5, 0.62]], around + outlines.arc((0, 0), 1.28, -np.pi / 2, 0.0)])
    outer = np.concatenate([[[-1.5, -0.62]], around + outlines.arc((0, 0), 2.52, -np.pi / 2, 0.0)])
    walls = [Body.wall(outlines.strip(line, 0.1, closed=False), 0.35, "wall") for line in (inner, outer)]
    boxes = [
        Body.prism(outlines.box(0.62, 0.5, 0.3, 0.2, 0.4), 0.3, "obstacle"),
        Body.prism(outlines.box(0.3, -0.6, 0.2, 0.2, 0.1), 0.4, "obstacle"),
    ]
    pillars = [
        Body.prism(outlines.circle(x, y, radius), height, "obstacle")
        for x, y, radius, height in (
            (0.35, 0.2, 0.06, 0.3),
            (0.55, -0.25, 0.07, 0.4),
            (0.7, 0.1, 0.08, 0.25),
            (0.2, -0.1, 0.05, 0.2),
        )
    ]
    return [*walls, *boxes, *pillars]


def measure(cols: int, rows: int, rounds: int = 60) -> RenderCost:
    """Return what rendering frames of this size costs, one OpenCV thread, rounds interleaved."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    camera, faces, renderer = _world(cols, rows)
    film = Film(noise_sigma_gray=2.0, rng=np.random.default_rng(0))

    def frame(x_m: float) -> Frame:
        then = Placed.at(camera, faces, x_m - 0.03, 0.0, -0.02)
        now = Placed.at(camera, faces, x_m, 0.0, 0.0)
        made = renderer.render(now, then)
        _ = film.exposed(made.gray), made.depth_m, made.obstacle, made.flow_px  # computed where asked for
        return made

    before = frame(-0.03)
    now = before
    places = itertools.count()

    def render() -> None:
        nonlocal now
        now = frame(0.001 * next(places))

    rivals = {
        "render": timed(render, time.thread_time),
        "Farneback": timed(lambda: _farneback(before.pixels, now.pixels), time.thread_time),
    }
    turns = take_turns(rivals, rounds, warm_up=3)
    cv2.setNumThreads(threads)
    visible = len(np.unique(now.surface[now.surface >= 0]))
    return RenderCost(
        visible, 1e3 * turns.median("render"), 1e3 * turns.median("Farneback"), turns.ratio("render", "Farneback")
    )


def _world(cols: int, rows: int) -> tuple[Camera, Faces, Renderer]:
    rng = np.random.default_rng(0)
    camera = Camera(cols=cols, rows=rows)
    faces = faces_of(bodies(), rng)
    atlas = Atlas([Texture()] * (1 + len(faces.textures)), floor_texels((10.0, 10.0)), rng)
    return camera, faces, Renderer(camera, faces, atlas, np.array([-5.0, -5.0]))


def _farneback(before: Bytes, now: Bytes) -> None:
    cv2.calcOpticalFlowFarneback(
        before, now, None, pyr_scale=0.5, levels=3, winsize=15, iterations=3, poly_n=5, poly_sigma=1.2, flags=0
    )


def main() -> None:
    """Print the cost at two image sizes."""
    for cols, rows in ((160, 120), (320, 240)):
        cost = measure(cols, rows)
        print(
            f"{cols}x{rows}, {cost.faces} faces in view: render with truth {cost.render_ms:.2f} ms, "
            f"Farneback {cost.farneback_ms:.2f} ms, ratio {cost.ratio}"
        )


if __name__ == "__main__":
    with load_told():
        main()
