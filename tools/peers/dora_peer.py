"""dora: two nodes of a dataflow that its own ``dora run`` starts; Arrow arrays in shared memory.

Large buffers: a queue of 1000 messages in place of dora's own.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pyarrow as pa
from dora import Node

from peers.protocol import Job, Listener, main, pictures


def both(job: Job, folder: Path) -> None:
    """Run the dataflow."""
    queue = {"queue_size": 1000} if job.large else {}
    nodes: list[dict[str, Any]] = [
        {"id": "send", "outputs": ["image"]},
        {"id": "hear", "inputs": {"image": {"source": "send/image", **queue}}},
    ]
    for node in nodes:
        node |= {"path": sys.executable, "args": f"-m peers.dora_peer {folder} {node['id']}"}
    dataflow = folder / "dataflow.yml"
    dataflow.write_text(json.dumps({"nodes": nodes}))
    dora = shutil.which("dora", path=str(Path(sys.executable).parent))
    assert dora is not None
    words = [dora, "run", str(dataflow), "--stop-after", f"{job.max_s + 20:.0f}s"]
    subprocess.run(words, check=True, cwd=folder)


def hear(job: Job, folder: Path) -> None:
    """Listen; the array is a view of the shared memory."""
    listener, node = Listener(job, folder), Node()
    while not listener.is_over and (event := node.next(job.max_s)) is not None:
        if event["type"] == "INPUT":
            listener.take(event["value"].to_numpy(zero_copy_only=True).reshape(job.shape))
        elif event["type"] in {"STOP", "INPUT_CLOSED"}:
            break
    listener.finish()


def send(job: Job, folder: Path) -> None:
    """Send; ``dora run`` has started all nodes before the first message leaves."""
    node = Node()
    for pixels in pictures(job, folder):
        node.send_output("image", pa.array(pixels.reshape(-1)))


if __name__ == "__main__":
    main(both=both, hear=hear, send=send)
