"""A log that will be large is told of while there is time."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from graphnav.core.graph import Graph
from graphnav.core.runner.recording.log_forecast import LogForecast, size_text
from graphnav.core.runner.recording.run_recorded import run_recorded
from graphnav.core.spec import RecordOption

SMALL = "; for small messages only: --set run.record=small"
SMALLER = f"; for what a replay needs to make the rest again: --set run.record=replayable{SMALL}"


class Log:
    """A log of some size."""

    n_bytes = 0


def told(until_s: float | None, tick_bytes: int, free_bytes: float = 1e12, ticks: int = 100) -> list[str]:
    """Return what is told of a run at 10 Hz whose first tick holds a large message."""
    log, notices = Log(), list[str]()
    forecast = LogForecast(until_s, log, Path(), notices.append, lambda _: int(free_bytes))
    for k in range(ticks):
        forecast.before_tick(100_000 * k)
        log.n_bytes += tick_bytes if k else 40_000_000
    return notices


def test_a_log_above_1_gb_is_told_once() -> None:
    assert told(600, 700_000) == [f"the log will take about 4.2 GB by 600 s{SMALLER}"]


@pytest.mark.parametrize(("until_s", "ticks"), [(60, 100), (None, 100), (600, 20), (1.0, 11)])
def test_other_logs_are_not(until_s: float | None, ticks: int) -> None:
    assert told(until_s, 700_000, ticks=ticks) == []


def test_a_log_that_nearly_fills_the_disk_is_reported() -> None:
    assert told(60, 700_000, 600e6) == []
    assert told(60, 700_000, 500e6) == [f"the log will take about 459 MB by 60 s, 500 MB are free{SMALLER}"]


@pytest.mark.parametrize(
    ("n_bytes", "text"),
    [(0, "0 B"), (999, "999 B"), (1000, "1 kB"), (999_600, "1 MB"), (262_900_000, "263 MB"), (1.44e9, "1.4 GB")],
)
def test_sizes_are_short(n_bytes: float, text: str) -> None:
    assert size_text(n_bytes) == text


FREE = SimpleNamespace(free=10**12)
"""A disk with space, whatever the machine's has."""

NOISE = """
    stages:
      n: {use: probe.noise, with: {rate_hz: 100, rows: 480}}
      sink: {use: probe.counter, with: {last: 30, rate_hz: 100}}
"""


@pytest.mark.parametrize(("record", "hint"), [("all", SMALLER), (None, SMALL), ("replayable", SMALL), ("small", None)])
def test_a_large_log_is_forecast(
    load: Callable[[str], Graph],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    record: RecordOption | None,
    hint: str | None,
) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda _: FREE)
    graph = load(NOISE)
    graph = replace(graph, run=replace(graph.run, record=record, until_s=1000.0))
    notices: list[str] = []
    summary = run_recorded(graph, graph.make_stages(), tmp_path, notice=notices.append)
    assert summary.outcome == "goal"
    assert notices == ([] if hint is None else [f"the log will take about 3.1 GB by 1000 s{hint}"])
