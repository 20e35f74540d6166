"""The lines between ``graphnav up`` and the command that it starts on a host, on that command's standard streams.

To the command: a line with the port on which to wait and the key, and then a line a second. Where none comes for 30 s,
or its input ends, the command ends: so it ends with the one who has started it, however that ended, and the key is
in no file and no list of arguments. From the command: a line when it waits for runs.
"""

from __future__ import annotations

import json
import os
import time
from pathlib import Path

from graphnav import Place, UserError
from graphnav.processes.descriptors import is_readable
from graphnav.processes.host_key import key_of

FROM_STDIN = Path("-")
"""In place of the file of a key: it comes as an order."""
ALIVE = b"\n"
PERIOD_S = 1.0
SILENT_S = 30.0
"""More than the cable may be out while the connection of ssh lasts, which then is given up as well."""
_STDIN = 0
_MAX_BYTES = 512
_WAITS = "waits on port"


def orders(port: int, key: bytes) -> bytes:
    """Return the first line to a command."""
    return json.dumps({"port": port, "key": key.hex()}).encode() + b"\n"


def waiting(port: int) -> str:
    """Return the line of a command that waits for runs."""
    return json.dumps({_WAITS: port})


def is_waiting(line: bytes) -> bool:
    """Whether a line is that of a command that waits for runs, and not one that something else there prints."""
    try:
        said = json.loads(line)
    except (ValueError, RecursionError):
        return False
    return isinstance(said, dict) and _WAITS in said


class Orders:
    """Those that this command gets: ``port`` and ``key``, and whether it has to end.

    Raises
    ------
    UserError
        None come.
    """

    def __init__(self) -> None:
        line = b""
        while not line.endswith(b"\n") and len(line) < _MAX_BYTES and is_readable(_STDIN, SILENT_S):
            if not (byte := os.read(_STDIN, 1)):
                break
            line += byte
        try:
            said = json.loads(line)
            self.port, key = int(said["port"]), key_of(said["key"])
        except (KeyError, TypeError, ValueError):
            key = None
        if key is None:
            what = "no port and key came on standard input"
            raise UserError.of(what, "name a file, or let 'graphnav up' start this command", Place("--key -"))
        self.key = key
        self._heard_s = time.monotonic()

    def are_over(self) -> bool:
        """Whether the one who gave them is gone."""
        while is_readable(_STDIN, 0.0):
            if not os.read(_STDIN, _MAX_BYTES):
                return True
            self._heard_s = time.monotonic()
        return time.monotonic() - self._heard_s > SILENT_S
