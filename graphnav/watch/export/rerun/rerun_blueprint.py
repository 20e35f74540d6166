"""The Rerun layout of a run: camera, flow and dominant plane above; map, plots and log below."""

from __future__ import annotations

from typing import Any

from graphnav import Flow, Image, Map, Message, Planar, Plane, Potential, State, Steering, Truth, Twist
from graphnav.watch.export.entries.topics import PICTURE, parts_of
from graphnav.watch.export.extras import require
from graphnav.watch.export.log_pass import POSES
from graphnav.watch.export.reader import Reader
from graphnav.watch.export.rerun.rerun_file import LOG_ENTITY
from graphnav.watch.export.rerun.rerun_scene import MAP, PATH, ROBOT

_PICTURES: tuple[type[Message], ...] = (Image, Flow, Plane, Potential, Planar, Truth)
"""The first three of these in a log are shown side by side."""
_SHOWN = 3

_PLOTS: tuple[tuple[str, type[Message], tuple[str, ...]], ...] = (
    ("speed and turning rate", Twist, ("v_mps", "omega_radps")),
    ("steering angle", Steering, ("theta_rad",)),
    ("obstacle ratio", Plane, ("obstacle_ratio",)),
    ("clearance", State, ("clearance_m",)),
)


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
        contents = [f"/{MAP}/**", f"/{ROBOT}/**", f"/{PATH}/**"]
        below.append(rrb.Spatial3DView(origin="/scene", contents=contents, name="map"))
    plots = [
        rrb.TimeSeriesView(
            origin="/", contents=[_entity(n, leaf) for n in of_kind[kind] for leaf in leaves], name=title
        )
        for title, kind, leaves in _PLOTS
        if kind in of_kind
    ]
    if plots:
        below.append(rrb.Vertical(*plots, name="plots"))
    log = rrb.TextLogView(origin=f"/{LOG_ENTITY}", name="log")
    rows = [rrb.Horizontal(*views) for views in (above, below) if views]
    return rrb.Blueprint(rrb.Vertical(*rows, log, row_shares=[2, 3, 1][-len(rows) - 1 :]), collapse_panels=True)


def _entity(channel: str, part: str) -> str:
    rr = require("rerun")
    return str(rr.new_entity_path([*parts_of(channel), part]))
