"""``graphnav export``: write a log as video, pictures, tables, or a file for Foxglove or Rerun."""

from __future__ import annotations

from pathlib import Path

from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.notices import print_notice
from graphnav.core.parameters import Parameter, command, flag, many
from graphnav.watch.commands.options import FROM_S, TO_S

FORMATS = {
    "mp4": "the panels as a video; with --channel the pictures of that channel",
    "images": "the images of a channel, unchanged: a folder of .pgm or .ppm files, named by their stamps in us",
    "csv": "scalars: a folder with a table for each channel; with --channel one file",
    "parquet": "the same with the types of the fields (extra: parquet)",
    "mcap": "for Foxglove: pictures, scalars to plot, map, path, log (extra: foxglove)",
    "rrd": "for Rerun: the same, with a layout (extra: rerun)",
    "rosbag2": "a ROS 2 bag with what has a standard ROS type: images, twists, odometry, maps, scans (extra: bags)",
}
"""Every format of `graphnav.watch.export` and its help."""

_EXAMPLES = """\
examples:
  graphnav export runs/a --to mcap -o a.mcap
  graphnav export runs/a --to csv -o tables
  graphnav export runs/a --to images --channel robot.image -o frames
  graphnav export runs/a --to csv --channel control.twist -o twist.csv
  graphnav export runs/a --to rosbag2 -o a_bag
  graphnav export runs/a --to mp4 --channel plane.plane --from 10s --until 20s -o plane.mp4
"""


@command(
    Options.RUN_OR_LOG,
    Parameter("kind", "--to", choices=tuple(FORMATS), required=True, help="the format, see below"),
    Parameter(
        "target",
        "-o",
        type=Path,
        metavar="FILE",
        required=True,
        help="the file, or the folder of pictures, tables or a bag",
    ),
    many(
        "channels",
        "--channel",
        metavar="NAME",
        help="only this channel, or those of a pattern ('robot.*'); may be given several times",
        offers="channels",
    ),
    FROM_S,
    TO_S,
    flag("force", "--force", "replace existing files"),
    Parameter(
        "storage",
        "--storage",
        choices=("mcap", "sqlite3"),
        default="mcap",
        help="the files of a ROS 2 bag (default: %(default)s)",
    ),
    *Options.TYPES,
    Shared.TRUST,
    examples="\n".join(["formats:", *(f"  {name:<9}{text}" for name, text in FORMATS.items()), "", _EXAMPLES]),
)
def main(args: CommandArguments) -> int:
    """Run the command: export, list the files and the losses."""
    from graphnav.core.cli import damage_told, opened, progress_bar
    from graphnav.core.machine import Console
    from graphnav.core.record import find_log
    from graphnav.core.runner import size_text
    from graphnav.watch.export import Selection, duration_s, export_log

    catalog = args.catalog()
    args.load_types(catalog)
    selection = Selection(tuple(args.channels), args.from_s, args.until_s)
    with opened(find_log(args.log), catalog, args.plugins) as recording, damage_told(recording):
        until_s = min(duration_s(recording), selection.until_s)
        with progress_bar(Console(stderr=True), f"export {args.kind}", until_s) as show:
            done = export_log(
                recording,
                args.kind,
                args.target,
                selection,
                force=args.force,
                storage=args.storage,
                catalog=catalog,
                on_time=lambda at_s: show(round(at_s * 1e6)),
            )
    print(f"{args.target}: {done.contents}, {size_text(done.n_bytes)}")
    for loss in done.losses:
        print_notice(loss)
    return Exit.OK
