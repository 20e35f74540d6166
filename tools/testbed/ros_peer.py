"""A ROS 2 program without ROS: a process that publishes and subscribes topics by the Python classes of Cyclone DDS.

The process is `testbed.ros_program`. Commands go to it as JSON lines, and so comes what is heard.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

PATIENCE_S = 60.0
LOOPBACK = (
    '<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="lo"/></Interfaces>'
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    '<MaxAutoParticipantIndex>63</MaxAutoParticipantIndex><Peers><Peer Address="127.0.0.1"/></Peers></Discovery>'
    "</Domain></CycloneDDS>"
)
"""How a program of Cyclone DDS is kept on this machine, as its variable ``CYCLONEDDS_URI``."""


class RosPeer:
    """The process, as a test sees it; ``heard``: what came, as (topic, fields, monotonic arrival)."""

    def __init__(self, domain: int) -> None:
        self.domain = domain
        self.heard: list[tuple[str, Mapping[str, Any], float]] = []
        self._process = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name("ros_program.py")), str(domain)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"CYCLONEDDS_URI": LOOPBACK},
        )
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    @property
    def pid(self) -> int:
        """The process's id."""
        return self._process.pid

    def listen(self, topic: str, kind: str, *, latched: bool = False) -> None:
        """Subscribe a topic."""
        self._tell({"listen": topic, "kind": kind, "latched": latched})

    def offer(self, topic: str, kind: str, writers: int = 1) -> None:
        """Prepare to publish on a topic, by so many publishers."""
        self._tell({"offer": topic, "kind": kind, "writers": writers})

    def say(self, topic: str, fields: Mapping[str, Any], writer: int = 0) -> None:
        """Publish a message; ``data`` may be ``[size, value]`` for bytes, fields that are missing are zero."""
        self._tell({"say": topic, "fields": fields, "writer": writer})

    def say_bytes(self, topic: str, data: bytes) -> None:
        """Publish bytes as they are, as a program with faults would."""
        self._tell({"bytes": topic, "hex": data.hex()})

    def show(self, topic: str, level: int, size: tuple[int, int] = (24, 32), **changed: Any) -> int:
        """Publish a picture of one gray level, stamped now; return its stamp, microseconds."""
        utime = time.time_ns() // 1000
        rows, cols = size
        fields = {
            "header": header(utime),
            "height": rows,
            "width": cols,
            "encoding": "mono8",
            "step": cols,
            "data": [rows * cols, level],
        }
        self.say(topic, fields | changed)
        return utime

    def of(self, topic: str) -> list[Mapping[str, Any]]:
        """Return what was heard on a topic."""
        return [fields for name, fields, _ in self.heard if name == topic]

    def speeds(self, topic: str) -> list[float]:
        """Return the forward speed of every twist that was heard on a topic."""
        return [fields["linear"]["x"] for fields in self.of(topic)]

    def wait_for(self, holds: Callable[[], bool], meanwhile: Callable[[], object] = lambda: None) -> None:
        """Wait until something holds; fail where it never does."""
        end_s = time.monotonic() + PATIENCE_S
        while not holds():
            assert time.monotonic() < end_s, "it never came"
            meanwhile()
            time.sleep(0.02)

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(PATIENCE_S)
        self._thread.join(PATIENCE_S)
        assert self._process.stdout is not None
        self._process.stdout.close()

    def _tell(self, words: Mapping[str, Any]) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(words) + "\n")
        self._process.stdin.flush()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            words = json.loads(line)
            self.heard.append((words["topic"], words["fields"], time.monotonic()))


def header(utime: int, frame_id: str = "camera") -> dict[str, Any]:
    """Return the fields of a header with a stamp in microseconds."""
    return {"stamp": {"sec": utime // 1_000_000, "nanosec": utime % 1_000_000 * 1000}, "frame_id": frame_id}
