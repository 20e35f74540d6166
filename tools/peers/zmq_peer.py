"""pyzmq: PUB and SUB by a Unix socket, messages without copies, as its documentation advises for large arrays.

Large buffers: no limit of the queues (both high-water marks 0), whose default is 1000 messages.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import zmq

from peers.protocol import Job, Listener, await_ready, main, pictures, ready


def hear(job: Job, folder: Path) -> None:
    """Listen; the array is a view of the message."""
    listener = Listener(job, folder)
    socket = zmq.Context.instance().socket(zmq.SUB)
    if job.large:
        socket.set_hwm(0)
    socket.connect(f"ipc://{folder}/socket")
    socket.subscribe(b"")
    ready(folder)
    while not listener.is_late:
        if socket.poll(100):
            frame = socket.recv(copy=False)
            listener.take(np.frombuffer(frame.buffer, np.uint8).reshape(job.shape))
    listener.finish()


def send(job: Job, folder: Path) -> None:
    """Send without a copy."""
    socket = zmq.Context.instance().socket(zmq.PUB)
    if job.large:
        socket.set_hwm(0)
    socket.bind(f"ipc://{folder}/socket")
    await_ready(folder)
    for pixels in pictures(job, folder):
        left = socket.send(pixels, copy=False, track=True)
    left.wait(10)  # at its end this program frees what has not left yet


if __name__ == "__main__":
    main(hear=hear, send=send)
