"""A drawn map and a two-wheeled robot as a model of MuJoCo."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree as ET

import cv2
import numpy as np
from graphnav_world.geometry.scene import AMBIENT, SUN_W, Body, Faces
from graphnav_world.rendering.camera import Camera

from graphnav.arrays import Bytes, Doubles, Indices
from graphnav_mujoco import engine

FLOOR, BODY, ROBOT = range(3)
"""Kinds of geoms, in `user`; that of a moving body is BODY, too."""
HULL_GROUP, SHOWN_GROUP = 3, 0
"""Groups of geoms: those with contacts are not drawn, those that are drawn have none."""
FLOOR_BIT, BODY_BIT = 1, 2
"""Wheels and casters touch the floor, the robot's hull touches bodies."""
FLOOR_HALF_M, NEAR_M, FAR_M = 300.0, 0.02, 400.0
FLOOR_CELL_M = 0.25
"""OpenGL lights the corners of polygons: with a lamp the floor is squares of this size, as far as it shines."""
LAMP_HALF_M = 8.0
SUN_M = 8.0
"""Distance of the sun from the camera, around which shadows are drawn."""
SHININESS = 1.0
"""MuJoCo's 1.0 is OpenGL's exponent of 128, that of `Lighting` is 150."""
WHITE_RATIO = 2.0
"""OpenGL multiplies the reflection, too, by the texture, which is about half as bright as white."""
TIMESTEP_S = 0.002


@dataclass(frozen=True)
class Lights:
    """Shares of light as parameters of the world: of the lamp, its reflection, and what shadows take.

    ``headroom``: all is drawn darker by this factor, because OpenGL cuts light above one.
    """

    lamp: float
    glare: float
    shadow: float

    @property
    def headroom(self) -> float:
        """How much darker than it is the light is drawn."""
        return 3.0 if self.glare else 2.0 if self.lamp else 1.0


@dataclass(frozen=True)
class Chassis:
    """Measures of the base, in shares of its radius: a differential drive with a caster behind.

    The hull is a disc of ``radius_m``, or a rectangle of ``size_m``. ``wheel_m``: radius of the wheels, ``track_m``:
    from wheel to wheel.
    """

    radius_m: float
    size_m: tuple[float, float] | None

    @property
    def inner_m(self) -> float:
        """Radius of the circle into which wheels and caster fit."""
        return self.radius_m if self.size_m is None else min(self.size_m) / 2

    @property
    def wheel_m(self) -> float:
        """Radius of a wheel."""
        return 0.3 * self.inner_m

    @property
    def track_m(self) -> float:
        """Distance between the wheels."""
        return 1.5 * self.inner_m

    @property
    def mass_kg(self) -> float:
        """Mass of all: 10 kg at a radius of 0.2 m, with the square of it."""
        return 10.0 * (self.radius_m / 0.2) ** 2


def compile_model(
    bodies: Sequence[Body],
    faces: Faces,
    textures: Sequence[Bytes],
    periods_m: Sequence[Sequence[float]],
    floor_origin_m: Doubles,
    camera: Camera,
    lights: Lights,
    chassis: Chassis,
) -> Any:
    """Return the model; ``textures``: the floor's, then those of the faces, ``periods_m``: width and height of each."""
    root = ET.Element("mujoco")
    _add(root, "compiler", angle="radian", autolimits="true")
    _add(root, "option", timestep=TIMESTEP_S, integrator="implicitfast", cone="elliptic", impratio=10)
    _add(root, "statistic", extent=1, meansize=0.1, center="0 0 0")
    visual = _add(root, "visual")
    _add(visual, "global", offwidth=camera.cols, offheight=camera.rows)
    _add(visual, "quality", offsamples=0, shadowsize=2048 if lights.shadow else 0)
    black = _gray(0.0)
    _add(visual, "headlight", active=1, ambient=_gray(_sun(lights)[0]), diffuse=black, specular=black)
    _add(visual, "map", znear=NEAR_M, zfar=FAR_M, shadowclip=SUN_M)
    assets, world = _add(root, "asset"), _add(root, "worldbody")
    _add(assets, "texture", name="sky", type="skybox", builtin="flat", width=4, height=24, rgb1="1 1 1", rgb2="1 1 1")
    for k, texels in enumerate(textures):
        height, width = texels.shape
        _add(assets, "texture", name=f"t{k}", type="2d", builtin="flat", width=width, height=height)
        _add(assets, "material", name=f"m{k}", texture=f"t{k}", specular=lights.glare and 1.0, shininess=SHININESS)
    _add_floor(assets, world, np.array(periods_m[0], float), floor_origin_m, camera, lights)
    _add_lights(world, camera, lights)
    _add(world, "camera", name="eye", pos="0 0 1", fovy=2 * math.degrees(math.atan(camera.rows / 2 / camera.focal_px)))
    _add_shown(assets, world, faces, np.array(periods_m, float))
    _add_hulls(assets, world, bodies)
    _add_robot(root, world, chassis, camera, casts_shadow=bool(lights.shadow))
    mujoco = engine.load()
    model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    for k, texels in enumerate(textures):
        begin = model.tex_adr[1 + k]
        model.tex_data[begin : begin + 3 * texels.size] = cv2.cvtColor(texels, cv2.COLOR_GRAY2RGB).reshape(-1)
    return model


def _add(parent: ET.Element, tag: str, **attributes: object) -> ET.Element:
    texts = {name.rstrip("_"): _text(value) for name, value in attributes.items() if value is not None}
    return ET.SubElement(parent, tag, texts)


def _text(value: object) -> str:
    if isinstance(value, np.ndarray):
        return " ".join(map(repr, value.reshape(-1).tolist()))
    return " ".join(map(str, value)) if isinstance(value, (tuple, list)) else str(value)


def _add_mesh(
    assets: ET.Element, name: str, corners: Doubles, normals: Doubles, uv: Doubles, triangles: Indices
) -> None:
    """Add what is drawn; MuJoCo counts v of a texture from its last row."""
    _add(
        assets, "mesh", name=name, vertex=corners, normal=normals, texcoord=uv, face=triangles, inertia="shell",
    )  # fmt: skip


def _add_floor(
    assets: ET.Element,
    world: ET.Element,
    period_m: Doubles,
    origin_m: Doubles,
    camera: Camera,
    lights: Lights,
) -> None:
    center = np.round(origin_m + period_m / 2)
    steps = np.array([-FLOOR_HALF_M, FLOOR_HALF_M])
    if lights.lamp or lights.glare:
        half = LAMP_HALF_M + period_m.max() / 2
        n = round(2 * half / max(FLOOR_CELL_M, camera.height_m / 8))
        steps = np.concatenate([[-FLOOR_HALF_M], np.linspace(-half, half, n + 1), [FLOOR_HALF_M]])
    x, y = np.meshgrid(center[0] + steps, center[1] + steps)
    corners = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    # texture coordinates near zero are exact in the renderer's single precision
    begin = np.floor((corners[:, :2].min(axis=0) - origin_m) / period_m)
    uv = (corners[:, :2] - origin_m) / period_m - begin - np.round(FLOOR_HALF_M / period_m)
    k, side = np.arange(len(corners)).reshape(x.shape), slice(None, -1)
    quads: Indices = np.stack([k[side, side], k[side, 1:], k[1:, 1:], k[1:, side]], axis=-1).reshape(-1, 4)
    normals = np.tile([0.0, 0.0, 1.0], (len(corners), 1))
    _add_mesh(assets, "floor", corners, normals, uv, _triangles(quads))
    _add(world, "geom", name="shown_floor", type="mesh", mesh="floor", material="m0", user=FLOOR, **_SHOWN)
    _add(
        world, "geom", name="floor", type="plane", size="0 0 1", group=HULL_GROUP, contype=0, conaffinity=FLOOR_BIT,
        condim=1, friction="0 0 0", user=FLOOR,
    )  # fmt: skip


_SHOWN: dict[str, object] = {"contype": 0, "conaffinity": 0, "group": SHOWN_GROUP, "mass": 0}


def _add_lights(world: ET.Element, camera: Camera, lights: Lights) -> None:
    """Add the sun, as bright on the floor as in `shade`, and the lamp at the camera."""
    _, sun = _sun(lights)
    _add(
        world, "light", name="sun", directional="true", pos=SUN_M * SUN_W, dir=-SUN_W, castshadow=_flag(lights.shadow),
        ambient="0 0 0", diffuse=_gray(sun), specular="0 0 0",
    )  # fmt: skip
    if not (lights.lamp or lights.glare):
        return
    rays = camera.rays()
    cosine = 1 / np.linalg.norm(rays, axis=-1)
    down = rays @ -camera.R_RC[2]
    seen = down > 0
    distance = camera.height_m / np.maximum(down, 1e-9) / cosine
    mean = float((cosine * camera.height_m / distance**3)[seen].mean())
    _add(
        world, "light", name="lamp", pos="0 0 1", dir="0 0 -1", castshadow="false", cutoff=90, exponent=1,
        attenuation="0 0 1", ambient="0 0 0", diffuse=_gray(lights.lamp / mean / lights.headroom),
        specular=_gray(WHITE_RATIO * lights.glare * camera.height_m**2 / lights.headroom),
    )  # fmt: skip


def _sun(lights: Lights) -> tuple[float, float]:
    """Return the ambient light and the sun's, together 1 on the floor without a lamp.

    With shadows the sun's share is what they take.
    """
    on_floor = AMBIENT + (1 - AMBIENT) * float(SUN_W[2])
    share = lights.shadow or (1 - AMBIENT) * float(SUN_W[2]) / on_floor
    scale = (1 - lights.lamp) / lights.headroom
    return (1 - share) * scale, share / float(SUN_W[2]) * scale


def _flag(value: float) -> str:
    return "true" if value else "false"


def _gray(value: float) -> str:
    return " ".join([repr(float(value))] * 3)


def _add_shown(assets: ET.Element, world: ET.Element, faces: Faces, periods_m: Doubles) -> None:
    """Add what is drawn: one mesh for each texture of what stands, and the bodies that move."""
    body = faces.body.take(faces.face_of_prim)
    texture = faces.texture.take(faces.face_of_prim)
    moves = np.isin(body, faces.moving)
    for k in range(len(faces.textures)):
        _add_surface(assets, world, f"standing{k}", faces, np.flatnonzero(~moves & (texture == k)), periods_m)
    for number, one in enumerate(faces.moving):
        carrier = _add(world, "body", name=f"moving{number}", mocap="true")
        _add(carrier, "inertial", pos="0 0 0", mass=1, diaginertia="1 1 1")
        _add_surface(assets, carrier, f"shown{number}", faces, np.flatnonzero(body == one), periods_m)


def _add_surface(
    assets: ET.Element,
    parent: ET.Element,
    name: str,
    faces: Faces,
    prims: Indices,
    periods_m: Doubles,
) -> None:
    """Add quads of one texture, each corner with the coordinates in the texture that `BodyTexture` looks up."""
    if not len(prims):
        return
    quads = faces.quads[prims]
    face = faces.face_of_prim[prims]
    texture = 1 + int(faces.texture[face[0]])
    axes = np.stack([faces.u[face], faces.v[face]], axis=1) / periods_m[texture][:, None]
    uv = np.einsum("pac,pkc->pka", axes[..., :3], quads) + axes[:, None, :, 3]
    uv -= np.floor(uv[:, :1])
    corners = np.arange(4 * len(prims)).reshape(-1, 4)
    normals = faces.normal[face].repeat(4, axis=0)
    _add_mesh(assets, name, quads.reshape(-1, 3), normals, uv.reshape(-1, 2), _triangles(corners))
    _add(parent, "geom", name=name, type="mesh", mesh=name, material=f"m{texture}", user=BODY, **_SHOWN)


def _triangles(quads: Indices) -> Indices:
    """Return quads, (n, 4) counterclockwise, as triangles, (2 n, 3)."""
    halves: Indices = quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    return halves


def _add_hulls(assets: ET.Element, world: ET.Element, bodies: Iterable[Body]) -> None:
    """Add what the robot can touch: a box or a prism for each convex part of a body."""
    carriers = {element.get("name"): element for element in world.iter("body")}
    moving = 0
    for index, body in enumerate(bodies):
        parent = world
        if body.course is not None:
            parent = carriers[f"moving{moving}"]
            moving += 1
        for part, outline in enumerate(body.parts):
            _add_hull(assets, parent, f"hull{index}_{part}", outline, body.height_m)


def _add_hull(assets: ET.Element, parent: ET.Element, name: str, outline: Doubles, height_m: float) -> None:
    touched: dict[str, object] = {"contype": 0, "conaffinity": BODY_BIT, "group": HULL_GROUP, "mass": 0, "user": BODY}
    if len(outline) == 4 and np.allclose(outline[0] + outline[2], outline[1] + outline[3], atol=1e-9):
        along, across = outline[1] - outline[0], outline[2] - outline[1]
        length, width = float(np.linalg.norm(along)), float(np.linalg.norm(across))
        if abs(float(along @ across)) < 1e-9 * length * width:
            half = (length / 2, width / 2, height_m / 2)
            pos = (*outline.mean(axis=0).tolist(), height_m / 2)
            euler = (0, 0, math.atan2(*along[::-1].tolist()))
            _add(parent, "geom", name=name, type="box", size=half, pos=pos, euler=euler, **touched)
            return
    low = np.column_stack([outline, np.zeros(len(outline))])
    _add(assets, "mesh", name=name, vertex=np.concatenate([low, low + np.array([0.0, 0.0, height_m])]))
    _add(parent, "geom", name=name, type="mesh", mesh=name, **touched)


def _add_robot(root: ET.Element, world: ET.Element, chassis: Chassis, camera: Camera, *, casts_shadow: bool) -> None:
    """Add the base: its frame is on the floor, below the middle of the axle."""
    base = _add(world, "body", name="base")
    _add(base, "freejoint", name="free")
    inner, wheel, mass = chassis.inner_m, chassis.wheel_m, chassis.mass_kg
    wheel_kg, tray = 0.05 * mass, 0.9 * mass
    # the mass is low and a little behind the axle, so that it brakes without tipping
    gyration = 0.5 * inner
    i_z = tray * gyration**2
    _add(
        base, "inertial", pos=(-0.2 * inner, 0, 0.25 * inner), mass=tray, diaginertia=(0.6 * i_z, 0.6 * i_z, i_z)
    )  # fmt: skip
    hull: dict[str, object] = {"contype": BODY_BIT, "conaffinity": 0, "group": HULL_GROUP, "user": ROBOT}
    half_m = inner / 2
    if chassis.size_m is None:
        _add(base, "geom", name="hull", type="cylinder", size=(chassis.radius_m, half_m), pos=(0, 0, half_m), **hull)
    else:
        length, width = chassis.size_m
        _add(base, "geom", name="hull", type="box", size=(length / 2, width / 2, half_m), pos=(0, 0, half_m), **hull)
    if casts_shadow:  # above the camera, which looks down and does not see it
        pos = (0, 0, 1.1 * camera.height_m)
        size = (chassis.radius_m, 0.02 * camera.height_m)
        _add(base, "geom", name="roof", type="cylinder", size=size, pos=pos, user=ROBOT, **_SHOWN)
    rolls: dict[str, object] = {"contype": FLOOR_BIT, "conaffinity": 0, "group": HULL_GROUP, "user": ROBOT}
    caster = 0.15 * inner
    _add(
        base, "geom", name="caster", type="sphere", size=caster, pos=(-0.8 * inner, 0, caster), mass=0.001 * mass,
        condim=1, friction="0 0 0", **rolls,
    )  # fmt: skip
    actuators = _add(root, "actuator")
    for side, y in (("left", chassis.track_m / 2), ("right", -chassis.track_m / 2)):
        carrier = _add(base, "body", name=side, pos=(0, y, wheel))
        _add(carrier, "joint", name=side, type="hinge", axis="0 1 0", armature=1e-4 * mass)
        _add(
            carrier, "geom", name=f"{side}_wheel", type="ellipsoid", size=(wheel, 0.15 * wheel, wheel),
            mass=wheel_kg, friction=(1, 0.02 * wheel, 0.0001), condim=4, **rolls,
        )  # fmt: skip
        # the speed follows with a time constant of 20 ms
        _add(actuators, "velocity", name=side, joint=side, kv=mass * wheel**2 / 2 / 0.02)
