"""The heads of a log's events are what their messages begin with."""

from __future__ import annotations

from pathlib import Path

from graphnav import Recording, Twist
from graphnav.core.codec import encode, fingerprint
from graphnav.core.record import LogWriter


def test_heads_are_read_without_the_data(tmp_path: Path) -> None:
    data = encode(Twist(v_mps=1.0, omega_radps=2.0), 70, 5)
    with LogWriter(tmp_path / "log") as log:
        log.write("a", 7, data)
        log.write("b", 8, b"too short")
        log.write("a", 9, data + bytes(100))
    with Recording(tmp_path / "log") as recording:
        heads = list(recording.heads())
    kind = fingerprint(Twist.lcm_class)
    assert [tuple(head) for head in heads] == [
        ("a", 0, 7, len(data), kind, 70, 5),
        ("b", 0, 8, 9, b"", 0, 0),
        ("a", 1, 9, len(data) + 100, kind, 70, 5),
    ]
