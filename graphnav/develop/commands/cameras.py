"""``graphnav cameras``: list the cameras of this machine, and what they deliver."""

from __future__ import annotations

import json
from itertools import groupby
from typing import TYPE_CHECKING

from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.parameters import command

if TYPE_CHECKING:
    from graphnav import CameraDevice
    from graphnav.core.tables import Table

_EXAMPLES = """\
examples:
  graphnav cameras
  graphnav run camera_flow --set camera.device=1
  graphnav run camera_flow --set camera.device=C920 --set camera.camera_size=[1280,720] --set camera.pixel_format=MJPG
"""
_TRY = """\
no camera is connected: there is no device with pictures in /dev/video*
  plug one in and look at 'dmesg'; a container or a virtual machine needs it passed on (docker run --device /dev/video0)
  a phone or a network camera works by its URL: graphnav run camera_flow --set camera.device=http://10.0.0.5:8080/video
  without a camera, play a video as one: graphnav run camera_flow --set camera.device=clip.mp4"""


@command(Options.JSON, examples=_EXAMPLES)
def main(args: CommandArguments) -> int:
    """Run the command; the exit status is 1 if there is none."""
    from graphnav import cameras
    from graphnav.core.machine import Console
    from graphnav.core.tables import folded

    found = cameras()
    if args.json:
        print(json.dumps([_as_json(camera) for camera in found], indent=2))
    elif not found:
        print(_TRY)
    console = Console(highlight=False, soft_wrap=True)
    for camera in [] if args.json else found:
        console.print(f"{camera.name}: device {_short(camera)}, {camera.driver or camera.problem}", markup=False)
        if camera.modes:
            console.print(folded(_table(camera)))
    return Exit.OK if found else Exit.FAILED


def _short(camera: CameraDevice) -> str:
    """Return the number of a camera and its device file."""
    return f"{camera.path.removeprefix('/dev/video')} ({camera.path})"


def _table(camera: CameraDevice) -> Table:
    from graphnav.core.tables import Table

    rows = []
    for (letters, described), modes in groupby(camera.modes, lambda mode: (mode.pixel_format, mode.description)):
        lines = [(f"{mode.cols}x{mode.rows}", ", ".join(f"{rate:.3g}" for rate in mode.rates_hz)) for mode in modes]
        sizes, rates = zip(*lines, strict=True)
        rows.append((letters, described, "\n".join(sizes), "\n".join(rates)))
    return Table.plain(("format", "", "size", "Hz"), rows)


def _as_json(camera: CameraDevice) -> dict[str, object]:
    return camera._asdict() | {"modes": [mode._asdict() for mode in camera.modes]}
