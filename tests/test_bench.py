"""``tools/bench.py --help`` lists its parts."""

from __future__ import annotations

import bench
import pytest


def test_help_lists_the_parts(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        bench.arguments(["--help"])
    told = capsys.readouterr().out
    assert all(f"\n  {name} " in told for name in bench.PARTS)
    assert "bench_peers" in told


def test_a_part_that_does_not_exist(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        bench.arguments(["speed"])
    assert capsys.readouterr().err.endswith(f"'speed' is not a part; parts are {', '.join(bench.PARTS)}\n")
