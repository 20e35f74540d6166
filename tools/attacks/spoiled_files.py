"""Spoiled graphs, maps, studies, plans, pictures, logs and options, and the commands that read them."""

from __future__ import annotations

import contextlib
import io
import random
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from attacks.hostile_options import hostile_words
from attacks.python_door import DOOR, DOORS
from attacks.spoil import spoiled_bytes, spoiled_json, spoiled_text, spoiled_yaml
from graphnav.core.cli import main

ROOT = Path(__file__).resolve().parents[2]
GRAPHS = ROOT / "graphs" / "graphnav_graphs"
_PICTURES_GRAPH = """\
stages:
  camera: {use: %s, with: {path: %s}}
  flow: {use: flow.lucas_kanade, in: {image: camera.image}}
"""
_VIDEOS = {"video.avi": "MJPG", "video.mp4": "mp4v"}
_STUDY_WORDS = (
    "--vary",
    "steer=steer.pca,steer.random",
    "--seeds",
    "0:2",
    "--set",
    "run.until_s=0.3",
    "--gallery",
    "0",
)


class Case(NamedTuple):
    """A command line that reads a spoiled file."""

    words: list[str]
    file: Path


class Kind(NamedTuple):
    """A kind of file. ``prepare`` makes good ones in a folder; ``spoil`` a spoiled one, and a command that reads it."""

    prepare: Callable[[Path], object]
    spoil: Callable[[Path, random.Random], Case]


def _nothing(_: Path) -> None:
    pass


def _prepare_graphs(scratch: Path) -> None:
    """Write graphs with everything that they extend: what is spoiled is then read, and not missed for its parent."""
    for graph in ("corridor_ccw", "pillars", "navigate/doors", "navigate_robot", "suite/shake", "video_plane"):
        with contextlib.redirect_stdout(io.StringIO()) as printed, contextlib.redirect_stderr(io.StringIO()):
            main(["check", graph, "--resolved"])
        if text := printed.getvalue():
            (scratch / f"{graph.replace('/', '_')}.good").write_text(text)


def _graph(scratch: Path, drawn: random.Random) -> Case:
    text = drawn.choice(sorted(scratch.glob("*.good"))).read_text()
    file = scratch / "graph.yaml"
    file.write_bytes(spoiled_yaml(text, drawn))
    if drawn.random() < 0.2:
        words = ["run", str(file), "--until", "0.2", "--no-tap", "--no-pictures", "-o", str(_new(scratch))]
        return Case(words, file)
    return Case(["check", str(file), *(["--resolved"] if drawn.random() < 0.2 else [])], file)


def _map(scratch: Path, drawn: random.Random) -> Case:
    text = drawn.choice(sorted((GRAPHS / "maps").rglob("*.yaml"))).read_text()
    file = scratch / "map.yaml"
    file.write_bytes(spoiled_yaml(text, drawn))
    if drawn.random() < 0.2:
        words = ["run", "corridor_ccw", "--set", f"robot.map={file}", "--until", "0.2", "--no-tap", "--no-pictures"]
        return Case([*words, "-o", str(_new(scratch))], file)
    return Case(["check", "corridor_ccw", "--set", f"robot.map={file}"], file)


def _study(scratch: Path, drawn: random.Random) -> Case:
    text = drawn.choice(sorted((GRAPHS / "studies").glob("*.yaml"))).read_text()
    file = scratch / "study.yaml"
    file.write_bytes(spoiled_yaml(text, drawn))
    # So many runs that they would have to be confirmed, which cannot be done here.
    return Case(["ablate", str(file), "--seeds", "0:1001", "-o", str(scratch / "study")], file)


def _prepare_plan(scratch: Path) -> None:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        status = main(["ablate", "corridor_ccw", *_STUDY_WORDS, "-o", str(scratch / "good")])
    if status:
        raise RuntimeError("the study to be spoiled could not be made")


def _plan(scratch: Path, drawn: random.Random) -> Case:
    folder = scratch / "spoiled"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(scratch / "good", folder)
    file = drawn.choice(sorted(p for p in folder.rglob("*") if p.suffix in (".json", ".csv", ".yaml")))
    text = file.read_text()
    file.write_bytes(spoiled_json(text, drawn) if file.suffix == ".json" else spoiled_text(text, drawn))
    return Case(["ablate", "--report", str(folder)], file)


def _prepare_pictures(scratch: Path) -> None:
    import cv2  # noqa: PLC0415 - not needed by those who only read files
    import numpy as np  # noqa: PLC0415

    (scratch / "good").mkdir()
    noise = np.random.default_rng(0)
    for k, suffix in enumerate(("png", "jpg", "bmp", "tiff", "pgm")):
        cv2.imwrite(str(scratch / "good" / f"{k}.{suffix}"), noise.integers(0, 256, (24, 32), np.uint8))
    for name, codec in _VIDEOS.items():
        video = cv2.VideoWriter(str(scratch / "good" / name), cv2.VideoWriter.fourcc(*codec), 10.0, (64, 48))
        for _ in range(5):
            video.write(noise.integers(0, 256, (48, 64, 3), np.uint8))
        video.release()


def _picture(scratch: Path, drawn: random.Random) -> Case:
    folder = scratch / "spoiled"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    good = drawn.choice(sorted((scratch / "good").iterdir()))
    data = bytearray(good.read_bytes())
    if good.suffix == ".png" and drawn.random() < 0.3:
        data[16:24] = drawn.choice((b"\x00\x01\x86\xa0" * 2, b"\xff" * 8, b"\x00" * 8))
    file = folder / good.name
    file.write_bytes(spoiled_bytes(bytes(data), drawn))
    graph = scratch / "graph.yaml"
    camera = ("io.video", file) if good.name in _VIDEOS else ("io.images", f"{folder}/*{good.suffix}")
    graph.write_text(_PICTURES_GRAPH % (camera[0], f'"{camera[1]}"'))
    if drawn.random() < 0.5:
        return Case(["check", str(graph)], file)
    return Case(["run", str(graph), "--no-tap", "--no-pictures", "--until", "1", "-o", str(_new(scratch))], file)


def _prepare_log(scratch: Path) -> None:
    words = ["run", "corridor_ccw", "--until", "0.3", "--no-tap", "--no-pictures", "-o", str(scratch / "good")]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        status = main(words)
    if status:
        raise RuntimeError("the log to be spoiled could not be made")


def _log(scratch: Path, drawn: random.Random) -> Case:
    data = (scratch / "good" / "run.lcmlog").read_bytes()
    file = scratch / "spoiled.lcmlog"
    file.write_bytes(spoiled_bytes(data, drawn))
    out = _new(scratch)
    commands: Sequence[list[str]] = (
        ["info", str(file)],
        ["replay", str(file)],
        ["export", str(file), "--to", "csv", "-o", str(out)],
        ["figure", str(file), "-o", str(out)],
    )
    return Case(drawn.choice(commands), file)


def _prepare_door(scratch: Path) -> None:
    _prepare_graphs(scratch)
    _prepare_log(scratch)


def _door(scratch: Path, drawn: random.Random) -> Case:
    """Return a door of the package in place of a command."""
    name = drawn.choice(tuple(DOORS))
    if name == "arguments":
        file = scratch / "corridor_ccw.good"
    else:
        file = (_log if name == "log" else _graph)(scratch, drawn).file
    return Case([DOOR, name, str(file), str(drawn.randrange(10**6))], file)


def _options(scratch: Path, drawn: random.Random) -> Case:
    """Return hostile options of a command; the log that it may read is as it should be."""
    return Case(hostile_words(drawn), scratch / "good" / "run.lcmlog")


def _new(scratch: Path) -> Path:
    """Return the path of a folder that does not exist."""
    out = scratch / "out"
    shutil.rmtree(out, ignore_errors=True)
    return out


KINDS = {
    "graphs": Kind(_prepare_graphs, _graph),
    "maps": Kind(_nothing, _map),
    "studies": Kind(_nothing, _study),
    "plans": Kind(_prepare_plan, _plan),
    "pictures": Kind(_prepare_pictures, _picture),
    "logs": Kind(_prepare_log, _log),
    "options": Kind(_prepare_log, _options),
    "python": Kind(_prepare_door, _door),
}
