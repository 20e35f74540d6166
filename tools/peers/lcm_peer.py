"""python-lcm alone: lcm-gen's class of a picture, by UDP multicast on this machine."""

from __future__ import annotations

import struct
from pathlib import Path

import lcm
import numpy as np

from peers.protocol import Job, Listener, await_ready, main, pictures, ready

_CHANNEL = "PEER"
_HEAD = struct.Struct(">qqiiiii")


def _url(job: Job) -> str:
    buffer = "&recv_buf_size=8388608" if job.large else ""
    return f"udpm://239.255.82.4:{8100 + job.number}?ttl=0{buffer}"


def hear(job: Job, folder: Path) -> None:
    """Listen as lcm-gen's class of ``image_t`` decodes: bytes, without a copy to numpy."""
    listener = Listener(job, folder)

    def take(_channel: str, data: bytes) -> None:
        _, _, _, rows, cols, _, size = _HEAD.unpack_from(data, 8)
        listener.take(np.frombuffer(data, np.uint8, size, 8 + _HEAD.size).reshape(rows, cols))

    link = lcm.LCM(_url(job))
    link.subscribe(_CHANNEL, take).set_queue_capacity(0 if job.large else 30)
    ready(folder)
    while not listener.is_late:
        link.handle_timeout(100)
    listener.finish()


def send(job: Job, folder: Path) -> None:
    """Send what lcm-gen's class of ``image_t`` encodes."""
    link = lcm.LCM(_url(job))
    await_ready(folder)
    for k, pixels in enumerate(pictures(job, folder)):
        head = _HEAD.pack(k, k, 1, job.rows, job.cols, 1, pixels.size)
        link.publish(_CHANNEL, b"".join((bytes(8), head, pixels.tobytes())))


if __name__ == "__main__":
    main(hear=hear, send=send)
