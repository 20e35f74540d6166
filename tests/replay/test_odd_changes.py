"""Changes in a log that cannot be repeated are told, and run nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav.core.codec import encode
from graphnav.core.messages import Changed
from graphnav.core.record import LogWriter, Recording
from graphnav.replay.comparison.result import ReplayResult
from graphnav.replay.log.log_graph import LogGraph

LATE = "stages: {late: {use: again.late, in: {twist: gather.twist}}}"
ODD = (
    ("late", "again.late", "stages: {late: {use: again.late, in: {twist: none.twist}}}", "it reads none.twist, which "),
    (
        "late",
        "again.late",
        "stages: {late: {use: again.late, in: {twist: robot.image}}}",
        "it reads robot.image, which",
    ),
    ("late", "again.nothing", "stages: {late: {use: again.nothing}}", "family 'again' has no stage 'nothing'"),
    ("late", "again.late", "stages: {late: [", "YAML: expected the node content"),
    ("late", "again.late", "", "the graph is empty"),
    ("late", "again.late", "stages: {mean: {use: again.mean}}", "it is not in its message"),
    ("absent", "again.late", LATE, "the graph does not have it"),
)


def _with_changes(log: Path, path: Path, at_us: int, *changes: bytes) -> Path:
    """Return a copy of a log with messages of changes before a tick."""
    writer = LogWriter(path)
    with Recording(log) as recording:
        is_written = False
        for event in recording.events():
            if event.utime >= at_us and not is_written:
                is_written = True
                for data in changes:
                    writer.write(Changed.CHANNEL, at_us, data)
            writer.write(event.channel, event.utime, event.data)
    writer.close()
    return path


def _changed(stage: str, use: str, text: str, at_us: int = 1_000_000) -> bytes:
    return encode(Changed(stage=stage, use=use, words=(), stage_yaml=text), at_us, 0)


@pytest.mark.parametrize(("stage", "use", "text", "why"), ODD)
def test_a_change_that_cannot_be_repeated_is_told(
    record: Callable[..., Path],
    made: Callable[..., LogGraph],
    again: Callable[..., ReplayResult],
    tmp_path: Path,
    stage: str,
    use: str,
    text: str,
    why: str,
) -> None:
    log = _with_changes(record(), tmp_path / "odd.lcmlog", 1_000_000, _changed(stage, use, text))
    (notice,) = made(log).graph.notices
    assert f"'{stage}'" in notice
    assert why in notice
    assert all(channel.is_equal for channel in again(log).channels.values())


def test_a_damaged_change_is_told(record: Callable[..., Path], made: Callable[..., LogGraph], tmp_path: Path) -> None:
    log = _with_changes(record(), tmp_path / "odd.lcmlog", 1_000_000, _changed("late", "again.late", LATE)[:-3])
    (notice,) = made(log).graph.notices
    assert notice.endswith("a change of a stage is damaged, and not repeated")


def test_a_change_in_a_log_loads_no_plugin(
    record: Callable[..., Path], made: Callable[..., LogGraph], tmp_path: Path
) -> None:
    plugin = tmp_path / "bad.py"
    plugin.write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\nFAMILY = 'bad'\n")
    text = f"plugins: [{plugin}]\n{LATE}"
    log = _with_changes(record(), tmp_path / "odd.lcmlog", 1_000_000, _changed("late", "again.late", text))
    (change,) = made(log).changes
    assert change.node.name == "late"
    assert not (tmp_path / "ran").exists()
