"""``graphnav figure``: redraw the pictures of a recorded run from its log."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import UserError
from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.errors import shown_name
from graphnav.core.notices import print_notice
from graphnav.core.parameters import Parameter, command, flag, many
from graphnav.watch.commands.options import FROM_S, TO_S
from graphnav.watch.commands.quantities import log_time, period

if TYPE_CHECKING:
    from graphnav.core.report import LogPictures

_PICTURE_FORMATS = ("png", "svg", "pdf")


@command(
    Options.RUN_OR_LOG,
    Parameter("folder", "-o", type=Path, metavar="DIR", help="output folder (default: that of the log)"),
    flag("video", "--video", "also draw video.mp4"),
    many(
        "times_s",
        "--at",
        type=log_time,
        metavar="T",
        help="the panels of the frame at T (12.3s) instead; may be given several times",
    ),
    flag("rows", "--rows", "with --at: one picture of these frames, a row of panels each"),
    flag(
        "separation",
        "--separation",
        "with --at: one picture of these frames, a row each: image, flow, component, dominant plane",
    ),
    Parameter(
        "every_s",
        "--every",
        type=period,
        metavar="T",
        help="a contact sheet instead: a frame every T (0.5s)",
    ),
    FROM_S.but(help=f"of a contact sheet: {FROM_S.help}"),
    TO_S.but(help=f"of a contact sheet: {TO_S.help}"),
    Parameter(
        "format",
        "--format",
        choices=_PICTURE_FORMATS,
        default=_PICTURE_FORMATS[0],
        help="of the pictures (default: %(default)s)",
    ),
    Shared.TRUST,
)
def main(args: CommandArguments) -> int:
    """Run the command: draw, and list the files."""
    from graphnav.core.catalog import Catalog
    from graphnav.core.cli import damage_told, opened
    from graphnav.core.record import find_log
    from graphnav.core.report import LogPictures, removed_if_empty
    from graphnav.watch.loginfo import unfinished

    _check(args)
    log = find_log(args.log)
    if notice := unfinished(log):
        print_notice(f"{log}: {shown_name(notice)}; the pictures show the log up to there")
    folder = args.folder or log.parent
    catalog = Catalog()
    with opened(log, Catalog(args.trusted())) as recording, damage_told(recording):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with removed_if_empty(folder):
                drawn = _draw(args, LogPictures(catalog, recording, folder, f".{args.format}"))
        except OSError as error:
            raise UserError.of(
                f"cannot write into {folder}: {error.strerror}", "choose another folder with -o"
            ) from error
        if not drawn:
            raise UserError.of(f"{log} contains nothing to draw", "record images, planes or a robot's states")
    for path in drawn:
        print(path)
    for damage in (*recording.damaged, *filter(None, [recording.truncated])):
        print_notice(f"{log}: {damage}; the pictures show the rest")
    return Exit.OK


def _check(args: CommandArguments) -> None:
    """Raise UserError for options that do not go together."""
    if args.every_s is None and (args.from_s >= 0 or args.until_s < math.inf):
        raise UserError.of("--from and --until are for a contact sheet", "add --every 0.5s, or leave them out")
    for option, given in (("--rows", args.rows), ("--separation", args.separation)):
        if given and not args.times_s:
            raise UserError.of(f"{option} is for frames of given times", "add --at 2s --at 4s, or leave it out")


def _draw(args: CommandArguments, pictures: LogPictures) -> list[Path]:
    """Draw what the options ask for; return the files."""
    drawn: list[Path] = []
    if args.rows:
        drawn += pictures.draw_rows(args.times_s)
    if args.separation:
        drawn += pictures.draw_separation(args.times_s)
    if args.times_s and not (args.rows or args.separation):
        drawn += pictures.draw_frames(args.times_s)
    if args.every_s is not None:
        drawn += pictures.draw_sheet(args.every_s, args.from_s, args.until_s)
    if (not args.times_s and args.every_s is None) or args.video:
        drawn += pictures.draw(video=args.video)
    return drawn
