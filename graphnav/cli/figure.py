"""``graphnav figure``: draw the pictures of a recorded run again, from its log alone."""

from __future__ import annotations

import argparse
from pathlib import Path

from graphnav.cli.status import OK
from graphnav.errors import UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("run", metavar="RUN_OR_LOG", type=Path, help="a run folder, or a log")
    parser.add_argument(
        "-o", dest="folder", type=Path, metavar="DIR", help="where the pictures go (default: beside the log)"
    )
    parser.add_argument("--video", action="store_true", help="also draw video.mp4")


def main(args: argparse.Namespace) -> int:
    """Run the command: draw, and print what was written."""
    from graphnav.catalog import Catalog  # noqa: PLC0415
    from graphnav.record import find_log  # noqa: PLC0415
    from graphnav.report.pictures import draw_pictures  # noqa: PLC0415

    log = find_log(args.run)
    folder = args.folder or log.parent
    try:
        folder.mkdir(parents=True, exist_ok=True)
        drawn = draw_pictures(Catalog(), log, folder, video=args.video)
    except OSError as error:
        raise UserError.of(f"cannot write into {folder}: {error.strerror}", "choose another folder with -o") from error
    if not drawn:
        raise UserError.of(f"{log} holds nothing to draw", "record images, planes or a robot's states")
    for path in drawn:
        print(path)
    return OK
