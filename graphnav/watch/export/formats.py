"""The export formats."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from graphnav import UserError
from graphnav.core.catalog import Catalog
from graphnav.core.pictures import Pictures
from graphnav.watch.export.entries.run_entries import RunEntries
from graphnav.watch.export.entries.viewer_file import write_entries
from graphnav.watch.export.extras import require
from graphnav.watch.export.foxglove.mcap_file import McapFile
from graphnav.watch.export.pictures import write_pictures
from graphnav.watch.export.reader import Reader
from graphnav.watch.export.rerun.rerun_blueprint import blueprint_of
from graphnav.watch.export.rerun.rerun_file import RerunFile
from graphnav.watch.export.selection import Selection
from graphnav.watch.export.tables.csv_table import open_csv
from graphnav.watch.export.tables.parquet_table import open_parquet
from graphnav.watch.export.tables.tables import OpenTable, write_tables
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


FORMATS: dict[str, Callable[[Job], Written]] = {
    "mp4": _mp4,
    "images": _images,
    "csv": _csv,
    "parquet": _parquet,
    "mcap": _mcap,
    "rrd": _rrd,
}
"""The writer of each format."""
