"""Benchmark the way of a picture from a stage to one in another process, against LCM between two processes.

A source shows pictures at 50 Hz; a stage in a process of its own tells how long ago each was made. Beside it two bare
python-lcm programs with lcm-gen's class, and large buffers: from numpy pixels to numpy pixels. They take turns.
``python tools/bench_edges.py [ROUNDS]`` prints medians and ninth deciles of each size, and their ratio.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

from taking_turns import Ratio, load_told, results_in_turn
from testbed.drives import GRAPHNAV

SIZES = {19_200: (120, 160), 76_800: (240, 320), 307_200: (480, 640), 921_600: (720, 1280)}
"""Rows and columns by the number of bytes."""
RATE_HZ, RUN_S = 50, 4
MAX_RATIOS = {19_200: 1.0, 76_800: 1.0, 921_600: 0.8}
URL = "udpm://239.255.82.3:7993?ttl=0"
LARGE_BUFFER = "&recv_buf_size=8388608"
BARE = Path(__file__).with_name("bare_edge.py")
STAGES = Path(__file__).with_name("passing_stages.py")
GRAPH = """
run: {{until_s: {until_s}, record: small}}
stages:
  eye: {{use: passing.show, with: {{rows: {rows}, cols: {cols}, rate_hz: {rate_hz}}}}}
  there: {{use: passing.arrive, in: {{image: eye.image}}}}
deploy: {{one: {{stages: [eye]}}, other: {{stages: [there]}}}}
"""

Found = dict[str, float]


def of_graph(folder: Path, size: tuple[int, int]) -> Found:
    """Return the statistics of a paced run in two processes."""
    graph = folder / "edge.yaml"
    graph.write_text(GRAPH.format(until_s=RUN_S, rows=size[0], cols=size[1], rate_hz=RATE_HZ))
    run = Path(tempfile.mkdtemp(dir=folder)) / "run"
    options = ["--plugin", str(STAGES), "--pace", "1", "--no-tap", "--no-pictures", "-o", str(run)]
    subprocess.run([str(GRAPHNAV), "run", str(graph), *options], check=True, capture_output=True)
    found: Found = json.loads((run / "summary.json").read_text())["scores"]["there"]
    return found


def of_lcm(size: tuple[int, int], options: str) -> Found:
    """Return the statistics of two programs."""
    words = [sys.executable, str(BARE), URL + options, *map(str, (*size, RATE_HZ, RUN_S))]
    done = subprocess.run(words, check=True, capture_output=True, text=True)
    found: Found = json.loads(done.stdout)
    return found


def main(rounds: int) -> int:
    """Measure all sizes; return 1 where a median is beyond its limit."""
    missed = False
    with tempfile.TemporaryDirectory() as scratch:
        for n_bytes, size in SIZES.items():
            rivals: dict[str, Callable[[], Found]] = {
                "graphnav": partial(of_graph, Path(scratch), size),
                "lcm": partial(of_lcm, size, LARGE_BUFFER),
                "lcm, stock buffer": partial(of_lcm, size, ""),
            }
            turns = results_in_turn(rivals, rounds, warm_up=1)
            print(f"{n_bytes} bytes")
            for name, found in turns.items():
                p50, p90 = (Ratio.of([one[key] for one in found]) for key in ("p50_us", "p90_us"))
                lost = sum(RATE_HZ * RUN_S - one["pictures"] for one in found)
                print(f"  {name:18} p50 {_told(p50)} µs   p90 {_told(p90)} µs   {max(lost, 0):.0f} lost")
            ratio = Ratio.of([a["p50_us"] / b["p50_us"] for a, b in zip(turns["graphnav"], turns["lcm"], strict=True)])
            limit = MAX_RATIOS.get(n_bytes)
            print(f"  graphnav / lcm: {ratio}" + (f", at most {limit}" if limit else ""))
            missed |= limit is not None and ratio.median > limit
    return int(missed)


def _told(found: Ratio) -> str:
    return f"{found.median:.0f} [{found.low:.0f}, {found.high:.0f}]"


if __name__ == "__main__":
    with load_told():
        sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 7))
