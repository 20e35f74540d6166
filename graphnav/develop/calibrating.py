"""Ask the plugin that calibrates cameras, and write the camera's YAML for the stages of a graph."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from graphnav import (
    CalibrationBoard,
    CalibrationTask,
    CameraCalibration,
    Graph,
    Image,
    Place,
    PreparedCamera,
    UserError,
)
from graphnav.core.api import loaded
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Node
from graphnav.core.machine import write_atomically
from graphnav.core.spec import write_value

FAMILY = "io"
"""Of the plugin that reads pictures, and so calibrates."""
_MOUNT = ("camera_height_m", "tilt_deg", "fov_deg")
_DIGITS = 5
PLACE = Place("PICTURES")


class CameraFiles(NamedTuple):
    """The files of a calibration: the camera's YAML for graphs, the calibration of the lens, and the contact sheet."""

    camera: Path
    calibration: Path
    sheet: Path


def written_files(camera: Path, *, force: bool) -> CameraFiles:
    """Return the files beside a camera's YAML.

    Raises
    ------
    UserError
        Its name does not end in .yaml, or a file exists and must not be replaced.
    """
    if camera.suffix not in (".yaml", ".yml"):
        raise UserError.of(f"'{camera}' is not a YAML file", "name it my_camera.yaml", Place("-o"))
    files = CameraFiles(camera, camera.with_suffix(".calibration.yaml"), camera.with_suffix(".png"))
    existing = [file for file in files if file.exists()]
    if existing and not force:
        raise UserError.of(
            f"{existing[0]} already exists", "choose another file, or replace it with --force", Place("-o")
        )
    return files


def calibrated(task: CalibrationTask, graph: str, columns: int, files: CameraFiles) -> CameraCalibration:
    """Return the calibration; its files are written if it has no problem, the contact sheet always.

    ``graph``: whose stages the camera's YAML is for. ``columns``: of the pictures that they work on.

    Raises
    ------
    UserError
        The graph or the pictures cannot be read, the graph has no stage that is told of its camera, or no plugin
        calibrates.
    """
    if not task.pictures:
        raise UserError.of(
            "no picture is named", "write graphnav calibrate pictures/ --board 9x6 --square 0.025", PLACE
        )
    checked = loaded(graph, None, (), Catalog())
    told = told_stages(checked)
    catalog = Catalog()
    catalog.load(FAMILY)
    found: CameraCalibration | None = catalog.hook.graphnav_calibrate(task=task)
    if found is None:
        raise _no_plugin()
    if found.problem is None and found.prepared is not None:
        write_atomically(files.calibration, found.text)
        write_atomically(files.camera, _camera_yaml(checked, told, found, task.rotate_deg, columns, files))
    return found


def print_board(board: CalibrationBoard, file: Path) -> tuple[float, float]:
    """Write a board to be printed; return width and height of the page, metres.

    Raises
    ------
    UserError
        The board cannot be made, the file cannot be written, or no plugin prints.
    """
    catalog = Catalog()
    catalog.load(FAMILY)
    size: tuple[float, float] | None = catalog.hook.graphnav_print_board(board=board, file=file)
    if size is None:
        raise _no_plugin()
    return size


class ToldStages(NamedTuple):
    """Stages of a graph that the camera concerns.

    ``mounted``: those that are told height, tilt and view. ``preparing``: the one that undistorts, None where it is to
    be added, behind ``image``, the reference of the camera's pictures, which ``readers`` read at some port.
    """

    mounted: tuple[str, ...]
    preparing: str | None
    image: str
    readers: tuple[tuple[str, str], ...]


def told_stages(graph: Graph) -> ToldStages:
    """Return which stages of a graph the camera concerns.

    Raises
    ------
    UserError
        It has no pictures or those of several cameras.
    """
    mounted = tuple(node.name for node in graph.nodes if not node.is_source and {*_MOUNT} <= node.settings.keys())
    preparing = [node.name for node in graph.nodes if {"calibration", "rectify"} <= node.settings.keys()]
    if preparing:
        return ToldStages(mounted, preparing[0], "", ())
    images = [ref for ref, channel in graph.channels.items() if channel.message is Image and not _made(graph, ref)]
    if len(images) != 1:
        what = f"{graph.path.stem} has {len(images)} channels with pictures of a camera"
        raise UserError.of(what, "name a graph with one: --graph navigate_robot", Place("--graph"))
    readers = [
        (node.name, one.port.name)
        for node in graph.nodes
        for one in node.inputs
        # a guard judges the pictures as they come
        if one.channel is not None and one.channel.ref == images[0] and not node.stage_class.is_guard
    ]
    return ToldStages(mounted, None, images[0], tuple(readers))


def _made(graph: Graph, ref: str) -> bool:
    """Return whether a stage makes a channel from others."""
    nodes: dict[str, Node] = {node.name: node for node in graph.nodes}
    stage = graph.channels[ref].stage
    return stage in nodes and not nodes[stage].is_source


def _camera_yaml(
    graph: Graph, told: ToldStages, found: CameraCalibration, rotate_deg: int, columns: int, files: CameraFiles
) -> str:
    """Return the YAML that graphs extend."""
    assert found.prepared is not None
    camera = found.prepared
    settings: dict[str, object] = {"calibration": files.calibration.name, "rectify": True}
    if rotate_deg:
        settings["rotate_deg"] = rotate_deg
    settings["size"] = [columns, max(1, round(columns * camera.rows / camera.cols))]
    stages: dict[str, object] = {}
    if told.preparing is not None:
        stages[told.preparing] = {"with": settings}
    else:
        stages["prepare"] = {"use": "io.prepare", "with": settings, "in": {"image": told.image}}
        stages |= {stage: {"in": {port: "prepare.image"}} for stage, port in told.readers}
    for name in told.mounted:
        entry = stages.setdefault(name, {})
        assert isinstance(entry, dict)
        entry["with"] = {**entry.get("with", {}), **_mounting(camera)}
    head = [f"about: The camera of a robot, for {graph.path.stem}.", "", *_comments(graph, files, found), ""]
    lines = ["stages:", *(f"  {name}: {write_value(entry)}" for name, entry in stages.items())]
    return "\n".join([*head, *lines]) + "\n"


def _mounting(camera: PreparedCamera) -> dict[str, float]:
    """Return the parameters of the mounting, of which some are not known without pictures of the floor."""
    values = (camera.height_m, camera.tilt_deg, camera.fov_deg)
    return {name: round(value, _DIGITS) for name, value in zip(_MOUNT, values, strict=True) if value is not None}


def _comments(graph: Graph, files: CameraFiles, found: CameraCalibration) -> list[str]:
    lens, mounting = found.lens, found.mounting
    assert lens is not None
    n_used = sum(not one.refusal for one in found.pictures)
    focal = f"{lens.fx_px.value:.1f} +- {lens.fx_px.deviation:.1f} px"
    made = f"{lens.cols}x{lens.rows} pixels, focal length {focal}, {lens.rms_px:.2f} px rms over {n_used} pictures"
    lines = [
        f"# extends: [{graph.path.stem}, {files.camera.name}]",
        "#",
        f"# Written by graphnav calibrate: {made}.",
    ]
    if mounting is None:
        return [*lines, "# No pictures of the floor: camera_height_m and tilt_deg are those of the graph."]
    height_m, tilt_deg, roll_deg = (one.value for one in mounting)
    angles = f"tilted by {tilt_deg:.2f} and rolled by {roll_deg:.2f} degrees"
    return [
        *lines,
        f"# The camera is {height_m:.3f} m above the floor, {angles}; 'rectify' makes the picture level.",
    ]


def _no_plugin() -> UserError:
    return UserError.of("no installed plugin calibrates cameras", "install graphnav again", Place("calibrate"))
