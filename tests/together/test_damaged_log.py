"""A command that cannot use what is left of a damaged log says that it is damaged."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.messages import Twist
from graphnav.core.record import LogWriter


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["replay"], "does not hold the graph that produced it: no readable 'graphnav.about'"),
        (["figure"], "contains nothing to draw"),
        (["export", "--to", "csv", "-o", "tables"], "holds no messages"),
    ],
)
def test_the_damage_is_told_before_the_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: list[str], error: str
) -> None:
    monkeypatch.chdir(tmp_path)
    log = Path("cut.lcmlog")
    with LogWriter(log) as writer:
        writer.write("control.twist", 0, encode(Twist(v_mps=1.0, omega_radps=0.0), 0, 0))
    log.write_bytes(log.read_bytes()[:-1])
    assert main([words[0], str(log), *words[1:]]) == 2
    told = capsys.readouterr().err.splitlines()
    assert told[0] == "cut.lcmlog is damaged: the last event, 80 bytes from byte 0, is truncated"
    assert told[1] == "  'graphnav info' tells more"
    assert told[2] == f"cut.lcmlog {error}"
