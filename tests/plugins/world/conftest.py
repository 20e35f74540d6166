"""Worlds, and a slow ray caster that shares nothing with the renderer."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from graphnav_world.geometry import outlines
from graphnav_world.geometry.patrol import Patrol
from graphnav_world.geometry.scene import Body, Faces, faces_of
from graphnav_world.rendering.atlas import Atlas, floor_texels
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.render import Renderer
from graphnav_world.rendering.textures import Texture

from graphnav.arrays import Doubles, Ints

MAPS = Path(__file__).parents[3] / "graphs" / "graphnav_graphs" / "maps"


@pytest.fixture(autouse=True)
def _one_thread() -> None:
    cv2.setNumThreads(1)


@pytest.fixture
def maps() -> Path:
    """Return the folder of the maps that ship."""
    return MAPS


@pytest.fixture(scope="session")
def cast() -> Callable[[Camera, Placed, Faces], tuple[Ints, Doubles]]:
    """Return a function that gives every pixel's face and depth, both (rows, cols), by intersecting each ray."""

    def cast_rays(camera: Camera, placed: Placed, faces: Faces) -> tuple[Ints, Doubles]:
        rays = camera.rays().reshape(-1, 3) @ placed.R_WC.T
        eye = placed.eye_W
        with np.errstate(divide="ignore"):
            depth = np.where(rays[:, 2] < 0, -eye[2] / rays[:, 2], np.inf)
        face = np.full(len(rays), -1, np.int32)
        at = dict(placed.moving)
        for prim, owner in zip(faces.quads, faces.face_of_prim, strict=True):
            quad = prim + at.get(int(faces.body[owner]), np.zeros(3))
            normal = np.cross(quad[1] - quad[0], quad[2] - quad[0])
            with np.errstate(divide="ignore", invalid="ignore"):
                far = ((quad[0] - eye) @ normal) / (rays @ normal)
                hit = eye + rays * far[:, None]
                edges = zip(quad, np.roll(quad, -1, axis=0), strict=True)
                inside = np.all([(hit - a) @ np.cross(normal, b - a) >= -1e-12 for a, b in edges], axis=0)
            nearer = inside & (rays @ normal < 0) & (far > 0) & (far <= depth)
            depth[nearer], face[nearer] = far[nearer], owner
        shape = camera.rows, camera.cols
        return face.reshape(shape), depth.reshape(shape)

    return cast_rays


@pytest.fixture(scope="session")
def random_bodies() -> Callable[[int], list[Body]]:
    """Return a function that scatters walls that cross boxes, pillars and moving boxes around the origin."""

    def scatter(seed: int) -> list[Body]:
        rng = np.random.default_rng(seed)

        def somewhere() -> Doubles:
            return rng.uniform([-0.4, -0.9], [1.6, 0.9])

        bodies = []
        for _ in range(3):
            line = np.array([somewhere() for _ in range(3)])
            strip = outlines.strip(line, rng.uniform(0.03, 0.1), closed=False)
            bodies.append(Body.wall(strip, rng.uniform(0.1, 0.5), "wall"))
            (x, y), (length, width) = line.mean(axis=0), rng.uniform(0.2, 0.5, 2)
            box = outlines.box(x, y, length, width, rng.uniform(0, 3))
            bodies.append(Body.prism(box, rng.uniform(0.1, 0.5), "obstacle"))
        for _ in range(2):
            x, y = somewhere()
            pillar = outlines.circle(x, y, rng.uniform(0.05, 0.2))
            bodies.append(Body.prism(pillar, rng.uniform(0.1, 0.6), "obstacle"))
        path = Patrol(np.array([somewhere(), somewhere()]), speed_mps=0.4)
        bodies.append(Body.prism(outlines.box(0, 0, 0.2, 0.3, 0.5), 0.3, "wall", path))
        return bodies

    return scatter


@pytest.fixture(scope="session")
def world() -> Callable[..., tuple[Faces, Renderer]]:
    """Return a function that makes the faces and the renderer of bodies."""

    def make(camera: Camera, bodies: list[Body], seed: int = 0) -> tuple[Faces, Renderer]:
        rng = np.random.default_rng(seed)
        faces = faces_of(bodies, rng)
        atlas = Atlas([Texture()] * (1 + len(faces.textures)), floor_texels((5.0, 5.0)), rng)
        return faces, Renderer(camera, faces, atlas, np.array([-2.5, -2.5]))

    return make
