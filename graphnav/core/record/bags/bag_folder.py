"""The files of a ROS 2 bag, and what its metadata say of them."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePath
from typing import Any

from graphnav.core.errors import BagError, Place, UserError, shown_name
from graphnav.core.machine.files import open_regular
from graphnav.core.record.bags.library import StorageFile
from graphnav.core.spec import parse_yaml, read_bytes

METADATA = "metadata.yaml"
_ROOT = "rosbag2_bagfile_information"
_COMPRESSIONS = ("", "none", "message")


class BagFolder:
    """A bag: a folder with ``metadata.yaml`` that names its files, or one file.

    ``files``: in their order. ``types``: the ROS type of each topic, the first if it has several. The metadata are
    believed where the files do not tell: how they are compressed, and that none is missing.

    Raises BagError if the metadata or a file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.compresses_messages = False
        self._counts: dict[str, int] = {}
        self._paths = [path]
        if path.is_dir():
            self._read_metadata()
        try:
            for one in self._paths:
                os.close(open_regular(one))  # the library would wait for a FIFO
            self.n_bytes = sum(one.stat().st_size for one in self._paths)
        except OSError as error:
            raise BagError.of(f"{one}: {error.strerror}", "copy the bag again, with all its files") from error
        self.files: list[StorageFile] = []
        try:
            self.files += map(StorageFile, self._paths)
        except UserError:
            self.close()
            raise
        self.types: dict[str, str] = {}
        for file in self.files:
            for topic, ros_type in file.topics:
                self.types.setdefault(topic, ros_type)

    def close(self) -> None:
        """Close the files; idempotent."""
        for file in self.files:
            file.close()

    def check_counts(self, found: Mapping[str, int]) -> None:
        """Raise BagError if the files hold another number of messages than the metadata tell."""
        for topic, count in self._counts.items():
            if count != found.get(topic, 0):
                what = f"{count} messages on {topic}, but the files hold {found.get(topic, 0)}"
                raise BagError.of(
                    f"its metadata tell of {what}",
                    f"copy the bag again, or read a file of it: {shown_name(str(self._paths[0]))}",
                    Place(str(self.path / METADATA)),
                )

    def _read_metadata(self) -> None:
        place = Place(str(self.path / METADATA))
        try:
            values, problems = parse_yaml(read_bytes(self.path / METADATA, place), str(self.path / METADATA))
        except UserError as error:
            raise BagError(error.problems[:1]) from error
        if problems:
            raise BagError(problems[:1])
        root = values.plain()
        metadata = root.get(_ROOT) if isinstance(root, dict) else None
        if not isinstance(metadata, dict):
            hint = "name a folder that 'ros2 bag record' has written, or one of its files"
            raise BagError.of(f"it does not describe a ROS 2 bag: there is no '{_ROOT}'", hint, place)
        self._paths = [self.path / name for name in _file_names(metadata, place)]
        self.compresses_messages = _compression(metadata, place) == "message"
        self._counts = _counts(metadata)


def _file_names(metadata: Mapping[str, Any], place: Place) -> Iterator[str]:
    """Yield the names of the files, which lie in the folder whatever path the metadata give."""
    names = metadata.get("relative_file_paths")
    if not isinstance(names, list) or not names or not all(isinstance(name, str) for name in names):
        hint = "write the metadata again: ros2 bag reindex FOLDER"
        raise BagError.of("'relative_file_paths' does not list the files of the bag", hint, place)
    yield from (PurePath(name).name for name in names)


def _compression(metadata: Mapping[str, Any], place: Place) -> str:
    mode = str(metadata.get("compression_mode") or "").lower()
    if mode not in _COMPRESSIONS:
        what = f"compression_mode '{mode}' cannot be read"
        raise BagError.of(what, "expand its files (zstd -d), and name one of them in place of the folder", place)
    form = str(metadata.get("compression_format") or "")
    if mode == "message" and form != "zstd":
        raise BagError.of(f"compression_format '{form}' cannot be read", "write it again: ros2 bag convert", place)
    return mode


def _counts(metadata: Mapping[str, Any]) -> dict[str, int]:
    """Return the number of messages by topic, as far as the metadata tell."""
    counts: dict[str, int] = {}
    told = metadata.get("topics_with_message_count")
    for one in told if isinstance(told, list) else ():
        topic = one.get("topic_metadata") if isinstance(one, dict) else None
        name, count = (topic.get("name") if isinstance(topic, dict) else None), one.get("message_count") if topic else 0
        if isinstance(name, str) and isinstance(count, int):
            counts[name] = counts.get(name, 0) + count
    return counts
