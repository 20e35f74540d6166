"""Draw ``docs/navigate.webp``: a drive of the graph `navigate/pillars`; camera, dominant plane, own map, world."""

from __future__ import annotations

import subprocess
import sysconfig
import tempfile
from pathlib import Path

import cv2
import numpy as np
from graphnav_view import style
from graphnav_view.maps.local_map import draw_local_map
from graphnav_view.signals import Signals
from graphnav_view.track import track_of
from graphnav_view.video.camera_tiles import Stretch, camera_rgb, camera_tile, plane_tile
from graphnav_view.video.map_tile import TopView
from PIL import Image as Picture
from PIL import ImageDraw, ImageFont

from graphnav import Image, LocalMap, Map, Plane, Recording, Scene, State, Steering
from graphnav.arrays import Bytes
from graphnav.core.run_folder import RunFolder

ROOT = Path(__file__).resolve().parents[1]
GRAPHNAV = str(Path(sysconfig.get_path("scripts")) / "graphnav")
TARGET = ROOT / "docs" / "navigate.webp"
_GRAPH, _SEED = "navigate/pillars", "5"
_ROWS, _COLS, _GAP, _HEAD = 216, 288, 6, 26
_EVERY, _SHOWN_MS = 4, 100
"""Every fourth image, ten pictures a second: four times as fast as the drive."""
_END_MS = 2000
_QUALITY = 40
_FONT_PX = 15
_TITLES = ("camera", "dominant plane, obstacle red", "map of its own, no odometry", "world")
_KINDS = (Image, Plane, LocalMap, Steering, State)


def draw(run: Path, target: Path) -> None:
    """Draw the log of a run, from its first map to its end."""
    pictures = []
    with Recording(run / RunFolder.LOG) as recording:
        signals = Signals(recording)
        first, world, track = signals.first(Image), signals.first(Map), track_of(signals)
        assert first is not None
        assert world is not None
        assert track is not None
        rows, cols = first.pixels.shape[:2]
        stretch = Stretch(rows, cols, _ROWS, _COLS)
        view = TopView(Scene(world), track.pose[:, :2], track.moving, _COLS, _ROWS)
        path: list[tuple[float, float]] = []
        for number, (_, (image, plane, local, steering, state)) in enumerate(signals.joined(*_KINDS)):
            if state is not None:
                path.append((state.x_m, state.y_m))
            if number % _EVERY or image is None or plane is None or local is None:
                continue
            camera = camera_rgb(stretch, image)
            tiles = [
                camera_tile(stretch, camera, steering),
                plane_tile(stretch, camera, plane),
                _around(local),
                view.draw(state, np.array(path)),
            ]
            pictures.append(Picture.fromarray(np.hstack([_framed(tile) for tile in tiles])))
    for picture in pictures:
        _write_titles(picture)
    times = [_SHOWN_MS] * (len(pictures) - 1) + [_END_MS]
    pictures[0].save(
        target, save_all=True, append_images=pictures[1:], duration=times, loop=0, quality=_QUALITY, method=6
    )


def _around(local: LocalMap) -> Bytes:
    """Return the map at the tile's size, none of it cut off."""
    rows, cols = local.state.shape
    scale = min(_ROWS / rows, _COLS / cols)
    drawn = draw_local_map(local, round(rows * scale), round(cols * scale))
    above, left = (_ROWS - drawn.shape[0]) // 2, (_COLS - drawn.shape[1]) // 2
    below, right = _ROWS - drawn.shape[0] - above, _COLS - drawn.shape[1] - left
    tile: Bytes = cv2.copyMakeBorder(drawn, above, below, left, right, cv2.BORDER_CONSTANT, value=style.rgb("#9a9a9a"))
    return tile


def _framed(tile: Bytes) -> Bytes:
    framed: Bytes = cv2.copyMakeBorder(tile, _HEAD, 0, 0, _GAP, cv2.BORDER_CONSTANT, value=(255, 255, 255))
    return framed


def _write_titles(picture: Picture.Image) -> None:
    pen, font = ImageDraw.Draw(picture), ImageFont.load_default(_FONT_PX)
    for place, title in enumerate(_TITLES):
        pen.text((place * (_COLS + _GAP), 4), title, fill=(60, 60, 60), font=font)


def main() -> None:
    """Drive, and draw the drive."""
    with tempfile.TemporaryDirectory() as scratch:
        run = Path(scratch) / "run"
        command = [GRAPHNAV, "run", _GRAPH, "--seed", _SEED, "--record", "all", "--no-tap", "--no-pictures"]
        subprocess.run([*command, "-o", str(run)], check=True)
        draw(run, TARGET)


if __name__ == "__main__":
    main()
