"""The library that reads and writes the files of ROS 2 bags, and the encoding (CDR) of their messages.

It is imported here only. It reads files of any origin: whatever it raises becomes a `BagError`, and a chunk or message
that is compressed is expanded to the size that it declares and no further. Definitions of types that a bag brings are
not used, since the library makes Python code of them.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from graphnav.core.errors import BagError, UserError, message_line, shown_name
from graphnav.core.machine.extras import import_extra
from graphnav.core.messages import FieldError

EXTRA = "bags"
MAX_BYTES = 1 << 30
"""Of a message, and of a chunk of an MCAP file when it is expanded."""


def _library(module: str) -> Any:
    return import_extra(module, EXTRA, "a ROS 2 bag")


class RawMessage(NamedTuple):
    """A message as a bag holds it: its topic and ROS type, when it was recorded (ns), and its bytes in CDR."""

    topic: str
    ros_type: str
    logged_ns: int
    data: bytes


class StorageFile:
    """One file of a bag: MCAP (``.mcap``) or SQLite (``.db3``); ``topics``: names and ROS types, in its order.

    Raises BagError if the file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._reader: Any = None
        _bound_decompressors()
        with _faults(path):
            self._reader = _library("rosbags.rosbag2").Reader(path)
            self._reader.open()
            self._connections = list(self._reader.connections)
            self.topics = [(str(one.topic), str(one.msgtype)) for one in self._connections]
        self._check_encoding()

    def messages(self, from_ns: int | None = None) -> Iterator[RawMessage]:
        """Yield the messages in the order of their times, from a time on; raises BagError for damage."""
        if not self._connections:
            return
        with _faults(self.path):
            for connection, logged_ns, data in self._reader.messages(self._connections, start=from_ns):
                if not isinstance(logged_ns, int) or not isinstance(data, bytes) or len(data) > MAX_BYTES:
                    raise ValueError(f"a message on {connection.topic} is not bytes with a time")
                yield RawMessage(connection.topic, connection.msgtype, logged_ns, data)

    def close(self) -> None:
        """Close the file; idempotent."""
        reader, self._reader = self._reader, None
        if reader is not None and reader.is_open:
            reader.close()

    def __del__(self) -> None:
        self.close()

    def _check_encoding(self) -> None:
        for one in self._connections:
            if (encoding := str(one.ext.serialization_format)) != "cdr":
                self.close()
                what = f"{self.path}: the messages on {one.topic} are encoded as '{encoding}', not as ROS 2 does (cdr)"
                raise BagError.of(what, "record it with 'ros2 bag record'")


@contextmanager
def _faults(path: Path) -> Iterator[None]:
    """Make one error of everything that the library raises for a file; errors of graphnav pass."""
    try:
        yield
    except UserError:
        raise
    except Exception as error:  # a file of any origin, for which the library raises whatever its parsers do
        is_told = type(error).__name__ == "ReaderError"
        why = message_line(error).rstrip(".") if is_told else f"{type(error).__name__}: {message_line(error)}"
        what = f"{path} cannot be read as a ROS 2 bag: {why.rstrip(': ')}"
        raise BagError.of(what, _hint(path, str(error))) from error


def _hint(path: Path, text: str) -> str:
    """Return what to do about a file that cannot be read."""
    if path.suffix == ".mcap" and "Profile" in text:
        return "only the MCAP files of ROS 2 can be read: record it with 'ros2 bag record'"
    if path.suffix == ".mcap":
        return f"if its recording was cut off, repair it: mcap recover {shown_name(str(path))} -o repaired.mcap"
    return f"if its recording was cut off, repair it: sqlite3 {shown_name(str(path))} .recover"


@cache
def _bound_decompressors() -> None:
    """Let the library expand a chunk to the size that the chunk declares, not to what its bytes ask for."""
    storage = _library("rosbags.rosbag2.storage_mcap")
    lz4, zstd = _library("lz4.frame"), storage.zstd
    storage.DECOMPRESSORS.update(
        lz4=_bounded(lambda data, size: lz4.LZ4FrameDecompressor().decompress(data, max_length=size)),
        zstd=_bounded(lambda data, size: zstd.ZstdDecompressor().decompress(data, max_length=size)),
    )


def _bounded(expand: Callable[[bytes, int], bytes]) -> Callable[[bytes, int], bytes]:
    def expanded(data: bytes, n_bytes: int) -> bytes:
        if n_bytes > MAX_BYTES:
            raise ValueError(f"a chunk declares {n_bytes} bytes, more than the maximum of {MAX_BYTES}")
        return expand(data, n_bytes + 1)  # one more is a contradiction, which the library notices

    return expanded


def expand_message(data: bytes) -> bytes:
    """Return a message of a bag that compresses each of them; raises ValueError if it cannot be expanded."""
    zstd = _library("rosbags.rosbag2.storage_mcap").zstd
    decompressor = zstd.ZstdDecompressor()
    try:
        expanded: bytes = decompressor.decompress(data, max_length=MAX_BYTES)
    except (zstd.ZstdError, MemoryError) as error:
        raise ValueError(message_line(error)) from error
    if not decompressor.eof:
        raise ValueError("its compressed bytes are truncated, or larger than 1 GB")
    return expanded


class Cdr:
    """ROS messages to and from their bytes, by the definitions of the newest ROS 2 distribution."""

    def __init__(self) -> None:
        typesys = _library("rosbags.typesys")
        self.store = typesys.get_typestore(typesys.Stores.LATEST)

    def knows(self, ros_type: str) -> bool:
        """Whether a type is one of the standard ones."""
        return ros_type in self.store.fielddefs

    def make(self, ros_type: str, **fields: Any) -> Any:
        """Return a ROS message; ``ros_type`` as in ``geometry_msgs/msg/Twist``."""
        return self.store.types[ros_type](**fields)

    def encode(self, message: Any) -> bytes:
        """Return the bytes of a ROS message."""
        return bytes(self.store.serialize_cdr(message, message.__msgtype__))

    def decode(self, data: bytes, ros_type: str) -> Any:
        """Return a ROS message; raises FieldError or ValueError if the bytes are not one."""
        try:
            return self.store.deserialize_cdr(memoryview(data), ros_type)
        except FieldError:
            raise
        except Exception as error:  # bytes of any program, read by generated code
            raise ValueError(f"is not {ros_type}: {message_line(error)}") from error


class StorageWriter:
    """A new bag in a folder that does not exist; ``storage``: ``mcap`` or ``sqlite3``.

    Raises OSError if the disk refuses it.
    """

    def __init__(self, folder: Path, storage: str, cdr: Cdr) -> None:
        rosbag2 = _library("rosbags.rosbag2")
        self._cdr = cdr
        self._writer = rosbag2.Writer(folder, version=9, storage_plugin=rosbag2.StoragePlugin[storage.upper()])
        self._connections: dict[str, Any] = {}
        with _disk_errors():
            self._writer.open()

    def write(self, topic: str, ros_type: str, logged_ns: int, data: bytes) -> None:
        """Append a message, all of one topic with one type; raises OSError if the disk refuses it."""
        with _disk_errors():
            if topic not in self._connections:
                self._connections[topic] = self._writer.add_connection(topic, ros_type, typestore=self._cdr.store)
            self._writer.write(self._connections[topic], logged_ns, data)

    def close(self, *, is_complete: bool) -> None:
        """Write the index and the metadata, or give up the files of a bag that is not complete."""
        with _disk_errors():
            if not is_complete:
                self._abandon()
                return
            try:
                self._writer.close()
            except BaseException:
                self._abandon()
                raise

    def _abandon(self) -> None:
        """Close the file of the bag, to which a full disk lets nothing more be written."""
        with suppress(OSError):
            self._writer.abort()


@contextmanager
def _disk_errors() -> Iterator[None]:
    """Make OSError of what SQLite says about the disk."""
    try:
        yield
    except sqlite3.Error as error:
        raise OSError(message_line(error)) from error
