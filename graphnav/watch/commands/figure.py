"""``graphnav figure``: redraw the pictures of a recorded run from its log."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from graphnav.core.cli.options import add_trust_option
from graphnav.core.cli.quantities import log_time
from graphnav.core.cli.spans import add_span_options, period
from graphnav.core.cli.status import OK
from graphnav.core.errors import UserError, shown_name
from graphnav.core.notices import print_notice

PICTURE_FORMATS = ("png", "svg", "pdf")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("run", metavar="RUN_OR_LOG", type=Path, help="a run folder, or a log")
    parser.add_argument("-o", dest="folder", type=Path, metavar="DIR", help="output folder (default: that of the log)")
    parser.add_argument("--video", action="store_true", help="also draw video.mp4")
    parser.add_argument(
        "--at",
        dest="times_s",
        type=log_time,
        action="append",
        default=[],
        metavar="T",
        help="the panels of the frame at T (12.3s) instead; may be given several times",
    )
    parser.add_argument(
        "--rows", action="store_true", help="with --at: one picture of these frames, a row of panels each"
    )
    parser.add_argument(
        "--every", dest="every_s", type=period, metavar="T", help="a contact sheet instead: a frame every T (0.5s)"
    )
    add_span_options(parser, "of a contact sheet: ")
    parser.add_argument("--format", choices=PICTURE_FORMATS, default="png", help="of the pictures (default: png)")
    add_trust_option(parser)


def main(args: argparse.Namespace) -> int:
    """Run the command: draw, and list the files."""
    from graphnav.core.catalog import Catalog
    from graphnav.core.cli.opened_log import damage_told, opened
    from graphnav.core.cli.trust import trust_of
    from graphnav.core.record import find_log
    from graphnav.core.report.folder import removed_if_empty
    from graphnav.core.report.pictures import draw_all, draw_frames, draw_rows, draw_sheet
    from graphnav.watch.loginfo import unfinished

    if args.every_s is None and (args.from_s >= 0 or args.until_s < math.inf):
        raise UserError.of("--from and --until are for a contact sheet", "add --every 0.5s, or leave them out")
    if args.rows and not args.times_s:
        raise UserError.of("--rows is for frames of given times", "add --at 2s --at 4s, or leave it out")
    log = find_log(args.run)
    if notice := unfinished(log):
        print_notice(f"{log}: {shown_name(notice)}; the pictures show the log up to there")
    folder = args.folder or log.parent
    suffix = f".{args.format}"
    catalog = Catalog()
    with opened(log, Catalog(trust_of(args))) as recording, damage_told(recording):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            drawn: list[Path] = []
            with removed_if_empty(folder):
                if args.times_s:
                    draw = draw_rows if args.rows else draw_frames
                    drawn += draw(catalog, recording, args.times_s, folder, suffix)
                if args.every_s is not None:
                    drawn += draw_sheet(catalog, recording, args.every_s, (args.from_s, args.until_s), folder, suffix)
                if (not args.times_s and args.every_s is None) or args.video:
                    drawn += draw_all(catalog, recording, folder, suffix, video=args.video)
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
    return OK
