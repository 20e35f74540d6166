"""The protocol of `tools/bench_peers.py`: what is sent is counted, what arrives is timed, and what is lost is told."""

from __future__ import annotations

import sys
from pathlib import Path

import bench_peers
import pytest
from bench_peers import Found
from peers.protocol import Job

FEW = Job(rows=120, cols=160, rate_hz=50.0, n_warm_up=2, n_paced=10, flood_s=0.0, large=False, number=91)


@pytest.mark.parametrize("name", ["python-lcm", "graphnav edge"])
def test_pictures_are_timed_from_process_to_process(name: str) -> None:
    found = bench_peers.measured(name, FEW, Path(sys.prefix))
    assert found.sent == 10
    assert 1 <= found.arrived <= 10
    assert len(found.hops_us) == found.arrived
    assert min(found.hops_us) > 0
    assert found.out_of_order == 0


def test_what_is_lost_stands_beside_what_is_fast() -> None:
    ours = [Found([100.0, 120.0], 50.0, 100, 99, 10, 10, 0)] * 2
    theirs = [Found([200.0, 240.0], 90.0, 100, 100, 10, 4, 1)]
    found = {19_200: {("graphnav edge", "stock"): ours, ("zenoh", "stock"): theirs}}
    rows = bench_peers.rows_of(found)
    assert rows[0][:6] == ("19200", "graphnav edge", "stock", "110 [110, 110]", "118 [118, 118]", "198 of 200")
    assert rows[1][6:9] == ("90 [90, 90]", "4 of 10", "1")
    assert bench_peers.verdicts(found) == [
        (False, "19200 bytes: graphnav edge, stock buffers, lost 2 at 50 Hz"),
        (True, "19200 bytes: hop of graphnav edge / zenoh, stock: 0.50"),
    ]


def test_a_peer_that_fails_is_told_with_what_it_printed(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="dora ended with"):
        bench_peers.measured("dora", FEW, Path(sys.prefix))
