"""The export formats: the writer of each, and those of entries for viewers and of images."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from graphnav import Image, UserError
from graphnav.core.catalog import Catalog
from graphnav.core.pictures import Pictures
from graphnav.watch.export.entries.entries import Entry
from graphnav.watch.export.entries.run_entries import RunEntries
from graphnav.watch.export.extras import require
from graphnav.watch.export.files import placed_file, placed_folder
from graphnav.watch.export.foxglove import McapFile
from graphnav.watch.export.reader import Reader
from graphnav.watch.export.rerun import RerunFile, blueprint_of
from graphnav.watch.export.rosbag2 import write_bag
from graphnav.watch.export.selection import Selection
from graphnav.watch.export.tables import OpenTable, open_csv, open_parquet, write_tables
from graphnav.watch.export.video import write_video


class Written(NamedTuple):
    """The result of a format's writer: a description of the content, a sentence per missing part, the files."""

    contents: str
    losses: list[str]
    files: list[Path]


@dataclass(frozen=True)
class Job:
    """One export: source, selection and target."""

    reader: Reader
    selection: Selection
    catalog: Catalog
    target: Path
    force: bool
    storage: str
    """The kind of files of a ROS 2 bag."""

    @property
    def channel(self) -> str | None:
        """The channel, if exactly one is selected by name."""
        return self.selection.one_channel(self.reader.recording)

    @property
    def contents(self) -> str:
        """A description of the exported messages."""
        counts = self.reader.read
        return f"{counts.total()} messages of {len(counts)} channel{'s' if len(counts) != 1 else ''}"


def _mp4(job: Job) -> Written:
    if job.selection.patterns and job.channel is None:
        raise UserError.of(
            "a video shows one channel, or the panels",
            "select one channel with --channel, or omit --channel for the panels",
        )
    contents, losses = write_video(job.reader, job.selection, job.catalog, job.target, job.channel, force=job.force)
    return Written(contents, losses, [job.target])


def _images(job: Job) -> Written:
    count, files = write_pictures(job.reader, job.target, job.channel, force=job.force)
    return Written("1 picture" if count == 1 else f"{count} pictures", job.reader.losses(), files)


def _csv(job: Job) -> Written:
    return _tables(job, ".csv", open_csv)


def _parquet(job: Job) -> Written:
    require("pyarrow")
    return _tables(job, ".parquet", open_parquet)


def _tables(job: Job, suffix: str, open_table: OpenTable) -> Written:
    written = write_tables(job.reader, job.target, job.channel, suffix, open_table, force=job.force)
    files = "" if job.channel is not None else ", one file per channel"
    return Written(job.contents + files, job.reader.losses(), written)


def _mcap(job: Job) -> Written:
    require("foxglove")
    entries = RunEntries(job.reader, Pictures(job.catalog))
    write_entries(entries, job.target, ".mcap", McapFile, force=job.force)
    return Written(job.contents, entries.losses(), [job.target])


def _rrd(job: Job) -> Written:
    require("rerun")
    entries = RunEntries(job.reader, Pictures(job.catalog))
    begin_us, blueprint = job.reader.recording.begin_us, blueprint_of(job.reader)
    write_entries(entries, job.target, ".rrd", lambda file: RerunFile(file, begin_us, blueprint), force=job.force)
    return Written(job.contents, entries.losses(), [job.target])


def _rosbag2(job: Job) -> Written:
    losses, files = write_bag(job.reader, job.target, job.storage, force=job.force)
    return Written(job.contents, losses, files)


FORMATS: dict[str, Callable[[Job], Written]] = {
    "mp4": _mp4,
    "images": _images,
    "csv": _csv,
    "parquet": _parquet,
    "mcap": _mcap,
    "rrd": _rrd,
    "rosbag2": _rosbag2,
}
"""The writer of each format."""


class ViewerFile(Protocol):
    """A sink for the entries of a run."""

    def add(self, entry: Entry) -> None:
        """Write an entry."""

    def close(self) -> None:
        """Write buffered entries and close the file."""


def write_entries(
    entries: RunEntries, target: Path, suffix: str, open_file: Callable[[Path], ViewerFile], *, force: bool
) -> None:
    """Write the entries of a run into the file ``target``.

    Raises
    ------
    UserError
        The selection has no decodable message, or the target is not writable.
    GraphnavError
        Writing fails.
    """
    with placed_file(target, suffix, source=entries.reader.recording.path, force=force) as file:
        sink = open_file(file)
        try:
            for entry in entries:
                sink.add(entry)
        finally:
            sink.close()
        if not entries.reader.read.total():
            raise UserError.of(
                f"nothing to export from {entries.reader.recording.path}: no message can be decoded",
                "select other channels with --channel, or another span with --from and --until",
            )


def write_pictures(reader: Reader, target: Path, channel: str | None, *, force: bool) -> tuple[int, list[Path]]:
    """Write every image of ``channel`` to the folder ``target``; return their number and the files.

    Files are Netpbm (``.pgm`` for gray, ``.ppm`` for colour), which holds the pixels as they are, and are named by the
    images' stamps in microseconds.

    Raises
    ------
    UserError
        No channel of images is selected, or the target is not writable.
    GraphnavError
        Writing fails.
    """
    images = [name for name in reader.recording.channels if reader.message_type(name) is Image]
    selected = [name for name in images if name in reader.channels]
    if channel is None and len(selected) == 1:
        channel = selected[0]
    if channel is None or channel not in images:
        what = (
            f"{len(selected)} channels of images are selected"
            if channel is None
            else f"channel '{channel}' holds no images"
        )
        known = f"select one with --channel: {', '.join(images)}" if images else "export a log that holds images"
        raise UserError.of(what, known)
    names = []
    with placed_folder(target, source=reader.recording.path, force=force) as folder:
        for sample in reader.of(channel):
            image = reader.message(channel, sample.fields)
            if isinstance(image, Image):
                name = f"{sample.fields['utime']:016d}.{'pgm' if image.pixels.ndim == 2 else 'ppm'}"
                (folder / name).write_bytes(_netpbm(image))
                names.append(name)
    return len(names), [target / name for name in names]


def _netpbm(image: Image) -> bytes:
    rows, cols = image.pixels.shape[:2]
    kind = "P5" if image.pixels.ndim == 2 else "P6"
    return f"{kind}\n{cols} {rows}\n255\n".encode() + np.ascontiguousarray(image.pixels).tobytes()
