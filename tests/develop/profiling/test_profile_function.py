"""`graphnav.profile`: the profile of a run, from Python."""

from __future__ import annotations

import importlib.util
import shutil
from pathlib import Path

import pytest

import graphnav
from graphnav.core.trust import Request
from tests.core.api.conftest import STAGES


@pytest.fixture
def graph(tmp_path: Path) -> Path:
    """Return the file of a graph of eleven ticks."""
    path = tmp_path / "toy.yaml"
    path.write_text(
        "plugins: [door_stages.py]\nrun: {until_s: 1, seed: 3}\nstages:\n"
        "  sensor: {use: door.sensor}\n  steer: {use: door.steerer, in: {flow: sensor.flow}}\n"
    )
    shutil.copy(STAGES, tmp_path)
    Request(tmp_path, ()).remember()
    return path


def test_a_profile_has_tables_json_and_a_picture(graph: Path) -> None:
    found = graphnav.profile(graph, until_s=5, seed=4, set={"sensor.noise_px": 1})
    assert (found.graph, found.seed, found.outcome, found.failure) == ("toy", 4, "timeout", "")
    assert sum(found.parts.values()) == pytest.approx(found.tick_ms)
    assert str(found).startswith("toy: ")
    assert found.flame.startswith("<svg")
    assert found._repr_html_() == found.flame
    assert found.as_json()["ticks_per_s"] == found.ticks_per_s
    assert "tree" not in repr(found)


def test_the_run_folder_is_kept_if_it_is_named(graph: Path, tmp_path: Path) -> None:
    graphnav.profile(graph, until_s=5, folder=tmp_path / "here")
    assert (tmp_path / "here" / "run.lcmlog").stat().st_size > 0


def test_functions_are_sampled_on_request(graph: Path) -> None:
    pytest.importorskip("pyinstrument")
    assert graphnav.profile(graph, until_s=5, functions=True).ticks["sampled"] > 0


def test_a_run_that_fails_does_not_raise(graph: Path, caplog: pytest.LogCaptureFixture) -> None:
    found = graphnav.profile(graph, until_s=9, set={"sensor.grief": "raise", "sensor.grief_tick": 50})
    assert found.outcome == "failed"
    said = "stage 'sensor' (door.sensor) failed at 4.90 s: worn <b>out</b>"
    assert found.failure.splitlines() == [said, "  ValueError at door_stages.py:57 in _come_to_grief"]
    assert caplog.messages == [f"the run failed: {found.failure}"]


def test_too_few_ticks_are_an_error(graph: Path) -> None:
    with pytest.raises(graphnav.GraphnavError, match="nothing was measured: the run ended after 11 ticks"):
        graphnav.profile(graph)


@pytest.mark.parametrize("at_tick", [5, 50])
def test_an_interrupted_run_raises(graph: Path, at_tick: int) -> None:
    with pytest.raises(KeyboardInterrupt):
        graphnav.profile(graph, until_s=9, set={"sensor.grief": "interrupt", "sensor.grief_tick": at_tick})


def test_arguments_are_checked_before_the_run(graph: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(graphnav.UserError, match=r"tap must be \"thin\", \"full\" or \"none\", not 'thick' \(str\)"):
        graphnav.profile(graph, tap="thick")  # type: ignore[arg-type]
    with pytest.raises(graphnav.UserError, match=r"clock must be \"wall\" or \"cpu\", not 'sun' \(str\)"):
        graphnav.profile(graph, clock="sun")  # type: ignore[arg-type]
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "pyinstrument" else found(name))
    with pytest.raises(graphnav.UserError, match="pyinstrument is not installed\n  install it: pip install"):
        graphnav.profile(graph, functions=True)
