"""Zenoh: two peers joined by TCP on this machine; large payloads go by shared memory, which it does by default.

Large buffers: a pool of 64 MB in place of 16 MB, and a publisher that waits instead of dropping.
"""

from __future__ import annotations

import json
import time
from pathlib import Path

import numpy as np
import zenoh

from peers.protocol import Job, Listener, await_ready, main, pictures, ready

_KEY = "peer/image"


def _session(job: Job, kind: str) -> zenoh.Session:
    config = zenoh.Config()
    config.insert_json5("mode", '"peer"')
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5(f"{kind}/endpoints", json.dumps([f"tcp/127.0.0.1:{8300 + job.number}"]))
    if kind == "connect":
        config.insert_json5("listen/endpoints", "[]")
    config.insert_json5("transport/shared_memory/mode", '"init"')
    if job.large:
        config.insert_json5("transport/shared_memory/transport_optimization/pool_size", str(64 << 20))
    return zenoh.open(config)


def hear(job: Job, folder: Path) -> None:
    """Listen in the subscriber's callback, its fastest way; ``to_bytes`` copies."""
    listener = Listener(job, folder)

    def take(sample: zenoh.Sample) -> None:
        listener.take(np.frombuffer(sample.payload.to_bytes(), np.uint8).reshape(job.shape))

    with _session(job, "listen") as session:
        session.declare_subscriber(_KEY, take)
        ready(folder)
        while not listener.is_late:
            time.sleep(0.05)
    listener.finish()


def send(job: Job, folder: Path) -> None:
    """Send."""
    await_ready(folder)
    with _session(job, "connect") as session:
        wait = zenoh.CongestionControl.BLOCK if job.large else zenoh.CongestionControl.DROP
        publisher = session.declare_publisher(_KEY, congestion_control=wait)
        time.sleep(1.0)
        for pixels in pictures(job, folder):
            publisher.put(pixels.tobytes())


if __name__ == "__main__":
    main(hear=hear, send=send)
