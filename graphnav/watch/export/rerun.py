"""Write Rerun recordings, with the layout of a run."""

from __future__ import annotations

import math
from pathlib import Path as FilePath
from typing import Any
from uuid import uuid4

import numpy as np

from graphnav import Flow, Image, Map, Message, Planar, Plane, Potential, State, Steering, Truth, Twist
from graphnav.watch.export.entries.entries import Beams, Entry, Level, Line, Path, Picture, Pose, Robot, Scalars, World
from graphnav.watch.export.entries.solids import Rgb, Solid, bodies_of, goal_of, path_of, robot_of
from graphnav.watch.export.entries.topics import PICTURE, parts_of
from graphnav.watch.export.extras import require
from graphnav.watch.export.files import PipedFile
from graphnav.watch.export.log_pass import POSES
from graphnav.watch.export.reader import Reader
from graphnav.watch.export.scalar_fields import Leaf, leaves_of

_PICTURES: tuple[type[Message], ...] = (Image, Flow, Plane, Potential, Planar, Truth)
"""The first three of these in a log are shown side by side."""
_SHOWN = 3
_PLOTS: tuple[tuple[str, type[Message], tuple[str, ...]], ...] = (
    ("speed and turning rate", Twist, ("v_mps", "omega_radps")),
    ("steering angle", Steering, ("theta_rad",)),
    ("obstacle ratio", Plane, ("obstacle_ratio",)),
    ("clearance", State, ("clearance_m",)),
)
_APPLICATION, _TIMELINE = "graphnav", "time"
_SCENE, _MAP, _ROBOT, _PATH, _LOG_ENTITY = "scene", "scene/map", "scene/robot", "scene/path", "log"
_LEVELS = {Level.INFO: "INFO", Level.WARNING: "WARN", Level.ERROR: "ERROR"}
_HIT = (214, 39, 40)
_POINT = -2.0
"""Radius of the points of a scan: negative are those of the screen."""
_STAMPS = {"utime", "seq"}
_BATCH = 4096


def blueprint_of(reader: Reader) -> Any:
    """Return the blueprint for the selected channels of a log."""
    rrb = require("rerun.blueprint")
    of_kind: dict[type[Message] | None, list[str]] = {}
    for name in reader.channels:
        of_kind.setdefault(reader.message_type(name), []).append(name)
    pictured = [of_kind[kind][0] for kind in _PICTURES if kind in of_kind][:_SHOWN]
    above = [rrb.Spatial2DView(origin=_entity(name, PICTURE), name=name) for name in pictured]
    below = []
    if any(kind in of_kind for kind in (Map, *POSES)):
        contents = [f"/{_MAP}/**", f"/{_ROBOT}/**", f"/{_PATH}/**"]
        below.append(rrb.Spatial3DView(origin=f"/{_SCENE}", contents=contents, name="map"))
    plots = [
        rrb.TimeSeriesView(
            origin="/", contents=[_entity(n, leaf) for n in of_kind[kind] for leaf in leaves], name=title
        )
        for title, kind, leaves in _PLOTS
        if kind in of_kind
    ]
    if plots:
        below.append(rrb.Vertical(*plots, name="plots"))
    log = rrb.TextLogView(origin=f"/{_LOG_ENTITY}", name="log")
    rows = [rrb.Horizontal(*views) for views in (above, below) if views]
    return rrb.Blueprint(rrb.Vertical(*rows, log, row_shares=[2, 3, 1][-len(rows) - 1 :]), collapse_panels=True)


def _entity(channel: str, part: str) -> str:
    rr = require("rerun")
    return str(rr.new_entity_path([*parts_of(channel), part]))


class RerunFile:
    """Writes entries to entities named like the channels: ``control/twist/v_mps``, ``robot/image/picture``.

    The map, the path and the robot are below ``scene``, lines of text on ``log``. The timeline ``time`` counts from the
    beginning of the log; ``log_time`` and ``log_tick`` are Rerun's own, of the export.
    """

    def __init__(self, file: FilePath, begin_us: int, blueprint: Any) -> None:
        self._rr = require("rerun")
        self._begin_us = begin_us
        self._stream = self._rr.RecordingStream(_APPLICATION, recording_id=uuid4(), send_properties=False)
        self._file = PipedFile(file)
        try:
            self._stream.save(self._file.path, default_blueprint=blueprint)
        finally:
            self._file.opened()
        self._columns: dict[str, RerunColumns] = {}
        self._scene = RerunScene(self._rr, self._stream)

    def add(self, entry: Entry) -> None:
        """Write an entry; raises OSError if writing fails."""
        self._file.check()
        at_s = (entry.utime - self._begin_us) / 1e6
        if isinstance(entry, Scalars):
            self._add_scalars(entry, at_s)
            return
        self._stream.set_time(_TIMELINE, duration=at_s)
        if isinstance(entry, Picture):
            image = self._rr.EncodedImage(contents=entry.png(), media_type="image/png")
            self._stream.log([*parts_of(entry.channel), PICTURE], image)
        elif isinstance(entry, Beams):
            self._scene.add_beams(entry)
        elif isinstance(entry, Line):
            text = f"{entry.source}: {entry.text}"
            self._stream.log(_LOG_ENTITY, self._rr.TextLog(text, level=_LEVELS[entry.level]))
        else:
            self._scene.add(entry)

    def close(self) -> None:
        """Write buffered data."""
        for columns in self._columns.values():
            columns.send(self._rr, self._stream)
        self._stream.disconnect()
        self._file.close()

    def _add_scalars(self, entry: Scalars, at_s: float) -> None:
        if entry.channel not in self._columns:
            self._columns[entry.channel] = RerunColumns(entry.channel, entry.lcm_class)
        columns = self._columns[entry.channel]
        if columns.add(entry, at_s):
            columns.send(self._rr, self._stream)


class RerunColumns:
    """The scalars of one channel: numbers and booleans, except timestamps and array sizes.

    In batches, which Rerun logs a hundred times faster than single values. Non-finite values become NaN, which plots
    show as a gap.
    """

    def __init__(self, channel: str, lcm_class: type) -> None:
        self._parts = parts_of(channel)
        self._leaves = [leaf for leaf in leaves_of(lcm_class) if _is_plotted(leaf)]
        self._times_s: list[float] = []
        self._values: list[list[float]] = [[] for _ in self._leaves]

    def add(self, entry: Scalars, at_s: float) -> bool:
        """Add the scalars of a message; return whether to send the batch."""
        self._times_s.append(at_s)
        for leaf, values in zip(self._leaves, self._values, strict=True):
            value = float(leaf.of(entry.fields))
            values.append(value if math.isfinite(value) else math.nan)
        return len(self._times_s) >= _BATCH

    def send(self, rr: Any, stream: Any) -> None:
        """Send the batch."""
        index = rr.TimeColumn(_TIMELINE, duration=self._times_s)
        for leaf, values in zip(self._leaves, self._values, strict=True):
            entity = rr.new_entity_path([*self._parts, leaf.name])
            stream.send_columns(entity, indexes=[index], columns=rr.Scalars.columns(scalars=values))
            values.clear()
        self._times_s = []


def _is_plotted(leaf: Leaf) -> bool:
    return not leaf.is_size and leaf.name not in _STAMPS and leaf.primitive != "string"


class RerunScene:
    """Logs maps, poses and paths to a recording stream."""

    def __init__(self, rr: Any, stream: Any) -> None:
        self._rr, self._stream = rr, stream

    def add(self, entry: World | Robot | Pose | Path) -> None:
        """Log an entry at the current time of the stream."""
        if isinstance(entry, World):
            self._add_world(entry)
        elif isinstance(entry, Robot):
            self._add_robot(entry)
        elif isinstance(entry, Pose):
            self._add_pose(entry)
        else:
            self._stream.log(_PATH, self._lines(path_of(entry)))

    def _add_world(self, entry: World) -> None:
        self._stream.log(_SCENE, self._rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        for index, body in enumerate(bodies_of(entry.scene)):
            entity = f"body_{index}" if body.moving is None else f"moving_{body.moving}/body"
            self._stream.log(f"{_MAP}/{entity}/sides", self._mesh(body), static=True)
            self._stream.log(f"{_MAP}/{entity}/rims", self._lines(body), static=True)
        if (goal := goal_of(entry.scene)) is not None:
            self._stream.log(f"{_MAP}/goal", self._lines(goal), static=True)

    def _add_robot(self, entry: Robot) -> None:
        for name, solid in zip(("outline", "seen"), robot_of(entry), strict=False):
            self._stream.log(f"{_ROBOT}/{name}", self._lines(solid), static=True)

    def add_beams(self, entry: Beams) -> None:
        """Log what the beams of a scan hit, at the current time of the stream; the points move with the robot."""
        points = np.pad(entry.scan.points_m(), ((0, 0), (0, 1)))
        cloud = self._rr.Points3D(points, radii=_POINT, colors=[_HIT])
        self._stream.log([*_ROBOT.split("/"), *parts_of(entry.channel)], cloud)

    def _lines(self, solid: Solid) -> Any:
        return self._rr.LineStrips3D(solid.lines, colors=[_bytes(solid.colour)] * len(solid.lines))

    def _mesh(self, solid: Solid) -> Any:
        assert solid.sides is not None
        vertices, triangles = solid.sides
        colours = [_bytes(solid.colour)] * len(vertices)
        return self._rr.Mesh3D(vertex_positions=vertices, triangle_indices=triangles, vertex_colors=colours)

    def _add_pose(self, entry: Pose) -> None:
        self._stream.log(_ROBOT, self._transform(entry.x_m, entry.y_m, entry.yaw_rad))
        for index, (x_m, y_m, yaw_rad) in enumerate(entry.moving.reshape(-1, 3).tolist()):
            if math.isfinite(x_m + y_m + yaw_rad):
                self._stream.log(f"{_MAP}/moving_{index}", self._transform(x_m, y_m, yaw_rad))

    def _transform(self, x_m: float, y_m: float, yaw_rad: float) -> Any:
        rotation = self._rr.RotationAxisAngle(axis=(0.0, 0.0, 1.0), radians=yaw_rad)
        return self._rr.Transform3D(translation=(x_m, y_m, 0.0), rotation=rotation)


def _bytes(colour: Rgb) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in colour)
    return red, green, blue
