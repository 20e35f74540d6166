"""graphnav: an image from a camera stage to a stage in another process.

Role ``edge``: of one live graph, a process for each stage; its buffers cannot be chosen. Role ``channel``: an LCM
output of one live graph is an input of another. With stock buffers its listener has the 212,992 bytes that a stock
Linux grants; large ones are those that graphnav asks for.
"""

from __future__ import annotations

import signal
import subprocess
import sysconfig
import time
from collections.abc import Sequence
from pathlib import Path

from peers.protocol import Job, main

_GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"
_PLUGIN = Path(__file__).with_name("graphnav_stages.py")
_CAMERA = "  camera: {{use: peer.camera, with: {{folder: '{folder}'}}}}\n"
_HEAR = "  hear: {{use: peer.hear, with: {{folder: '{folder}'}}, in: {{image: {image}}}}}\n"
_STOCK_BYTES = 212_992


def edge(job: Job, folder: Path) -> None:
    """Measure the way within a graph."""
    graph = folder / "edge.yaml"
    stages = _CAMERA.format(folder=folder) + _HEAR.format(folder=folder, image="camera.image")
    graph.write_text(f"run: {{record: small}}\nstages:\n{stages}")
    url = f"udpm://239.255.82.6:{8100 + job.number}?ttl=0"
    subprocess.run([*_words(graph, folder / "run", url), "--processes"], check=True)


def channel(job: Job, folder: Path) -> None:
    """Measure the way from one live graph to another."""
    sender, hearer = folder / "sender.yaml", folder / "hearer.yaml"
    sender.write_text(
        f"run: {{record: small}}\nstages:\n{_CAMERA.format(folder=folder)}"
        "outputs: {camera.image: {channel: PEER}}\n"
    )
    hearer.write_text(
        "run: {record: small}\ninputs:\n  peer.image: {channel: PEER, type: graphnav_lcm.image_t}\n"
        f"stages:\n{_HEAR.format(folder=folder, image='peer.image')}"
    )
    buffer = "" if job.large else f"&recv_buf_size={_STOCK_BYTES}"
    url = f"udpm://239.255.82.5:{8100 + job.number}?ttl=0{buffer}"
    with subprocess.Popen(_words(hearer, folder / "hear", url)) as listening:
        try:
            subprocess.run(_words(sender, folder / "send", url), check=True)
            time.sleep(0.5)
        finally:
            listening.send_signal(signal.SIGINT)


def _words(graph: Path, run: Path, url: str) -> Sequence[str]:
    options = ["--no-tap", "--no-pictures", "--url", url, "-o", str(run)]
    return [str(_GRAPHNAV), "run", str(graph), "--plugin", str(_PLUGIN), *options]


if __name__ == "__main__":
    main(edge=edge, channel=channel)
