"""A run that is late says so: behind its pace, over its deadlines."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from graphnav.core.graph import Graph
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.lockstep_inbox import LockstepInbox
from graphnav.core.runner.recording.run_recorded import run_recorded

Load = Callable[[str], Graph]

SLOW = """
    run: {until_s: 0.4}
    stages:
      n: {use: probe.counter, with: {rate_hz: 1000}}
      slow: {use: probe.slow, with: {step_ms: 4}, in: {twist: n.twist}}
"""


def test_a_paced_run_that_cannot_keep_up_tells_it_while_it_runs_and_in_the_summary(load: Load, tmp_path: Path) -> None:
    graph, notices = load(SLOW), list[str]()
    summary = run_recorded(graph, graph.make_stages(), tmp_path, pace_ratio=1.0, notice=notices.append)
    assert summary.behind_s >= 400 * 0.003
    assert summary.behind_s <= summary.wall_s - 0.4
    assert notices[0].startswith("behind the wall clock by ")
    assert notices[0].endswith(" ms, the pace allows 1 ms")
    assert len(notices) >= 2
    assert json.loads((tmp_path / RunFolder.SUMMARY).read_text())["behind_s"] == summary.behind_s


def test_a_run_without_a_pace_is_not_behind(load: Load, tmp_path: Path) -> None:
    graph, notices = load(SLOW), list[str]()
    summary = run_recorded(graph, graph.make_stages(), tmp_path, notice=notices.append)
    assert (summary.behind_s, notices) == (0.0, [])


def test_steps_over_their_deadline_are_counted(load: Load, tmp_path: Path) -> None:
    graph = load("""
        run: {until_s: 0.5}
        stages:
          n: {use: probe.counter, with: {rate_hz: 20}}
          late: {use: probe.slow, with: {step_ms: 3}, in: {twist: n.twist}, deadline_ms: 2}
          early: {use: probe.slow, in: {twist: n.twist}, deadline_ms: 60000}
          free: {use: probe.slow, in: {twist: n.twist}}
    """)
    stages = run_recorded(graph, graph.make_stages(), tmp_path).stages
    assert {name: did.missed for name, did in stages.items()} == {"n": None, "late": 11, "early": 0, "free": None}


def test_a_deadline_covers_the_delivery_of_what_a_step_publishes(
    load: Load, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put = LockstepInbox.put

    def slow_put(*message: Any) -> None:
        time.sleep(0.003)
        put(*message)

    monkeypatch.setattr(LockstepInbox, "put", slow_put)
    graph = load("""
        run: {until_s: 0.1}
        stages:
          n: {use: probe.counter, with: {rate_hz: 20}, deadline_ms: 2}
          free: {use: probe.plus, in: {twist: n.twist}}
    """)
    assert run_recorded(graph, graph.make_stages(), tmp_path).stages["n"].missed == 3
