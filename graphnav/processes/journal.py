"""Keep the steps of the stages of processes, so that they can be made again."""

from __future__ import annotations

import errno
import io
import json
import os
import struct
import tempfile
from array import array
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from graphnav import GraphnavError
from graphnav.core.runner import LOOK_BYTES, Encoded, is_nearly_full

_SIZE = struct.Struct("=I")
_BUFFER_BYTES = 1 << 20


class Given(NamedTuple):
    """A step that a process has made, or a change of a stage."""

    kind: int
    """Of its frame."""
    head: Any
    messages: tuple[bytes, ...]
    digest: int
    """Of what it published."""


class Journal:
    """A file without a name on the disk of a run folder, which is gone with this process, however that ends.

    A message is in it once, whatever number of stages read it. If the disk takes no more, or is nearly full, ``fault``
    says why, and nothing can be given again.
    """

    def __init__(self, folder: Path) -> None:
        self.fault = ""
        self._folder = folder
        self._n_bytes = self._looked_bytes = 0
        self._steps: dict[str, array[int]] = {}
        """Where the steps of each process are in the file."""
        self._file: io.BufferedWriter | None = None
        try:
            fd, path = tempfile.mkstemp(prefix=".given-", dir=folder)
            os.unlink(path)
            self._file = io.BufferedWriter(io.FileIO(fd, "wb"), _BUFFER_BYTES)
            self._fd = fd
        except OSError as error:
            self._give_up(error)

    def keep(self, process: str, kind: int, head: Any, messages: Sequence[Encoded], digest: int) -> None:
        """Append a step of a process, or a change; never raises."""
        if self._file is None:
            return
        try:
            for message in messages:
                if message.place < 0:
                    message.place = self._write(message.data)
            said = json.dumps([kind, head, [(m.place, len(m.data)) for m in messages], digest]).encode()
            self._steps.setdefault(process, array("Q")).append(self._write(_SIZE.pack(len(said)) + said))
        except OSError as error:
            self._give_up(error)
        if self._n_bytes - self._looked_bytes >= LOOK_BYTES:
            self._looked_bytes = self._n_bytes
            if is_nearly_full(self._folder):
                self._give_up(OSError(errno.ENOSPC, "the disk is nearly full"))

    def steps(self, process: str) -> Iterator[Given]:
        """Yield the steps of a process in their order; raises GraphnavError where they cannot be read."""
        try:
            if self._file is None:
                raise GraphnavError(self.fault)
            self._file.flush()
            for at in self._steps.get(process, ()):
                (n_bytes,) = _SIZE.unpack(os.pread(self._fd, _SIZE.size, at))
                kind, head, places, digest = json.loads(os.pread(self._fd, n_bytes, at + _SIZE.size))
                yield Given(kind, head, tuple(os.pread(self._fd, size, place) for place, size in places), digest)
        except OSError as error:
            self._give_up(error)
            raise GraphnavError(self.fault) from error

    def close(self) -> None:
        """Close the file, which frees its space."""
        file, self._file = self._file, None
        if file is not None:
            self._close(file)

    def _write(self, data: bytes) -> int:
        assert self._file is not None, "asked before"
        at = self._n_bytes
        self._file.write(data)
        self._n_bytes += len(data)
        return at

    def _give_up(self, error: OSError) -> None:
        self.fault = f"what it was given cannot be kept: {error.strerror or error}"
        self.close()

    @staticmethod
    def _close(file: io.BufferedWriter) -> None:
        try:
            file.close()
        except OSError:  # what is in its buffer is not wanted any more
            file.raw.close()
