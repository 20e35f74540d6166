"""Completion offers exactly what graphnav accepts."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override, load_graph, shipped_graphs
from graphnav.develop.completion.complete import override_candidates, stages_of
from graphnav.develop.completion.index import Index, build_index, cache_file, installed_index

PROGRAM = [sys.executable, "-m", "graphnav"]


@pytest.fixture(scope="module")
def index() -> Index:
    return build_index()


def test_every_stage_class_and_graph_is_in_the_index(index: Index) -> None:
    catalog = Catalog()
    assert set(index.params) == {f"{family}.{name}" for family in catalog.families() for name in catalog.names(family)}
    assert set(index.graphs) == set(shipped_graphs())
    assert {"detectors", "paper"} <= set(index.studies)
    assert {"Flow", "graphnav_lcm.flow_t"} <= set(index.types)
    assert "robot.image" in index.channels


def test_every_stage_that_can_be_swapped_in_loads(index: Index) -> None:
    uses = index.graphs["corridor_ccw"]
    offered = list(override_candidates("plane=", uses, index))
    assert "plane=plane.affine" in offered
    for override in offered:
        load_graph("corridor_ccw", Catalog(), [Override.parse(override)])


def test_a_stage_that_needs_what_it_writes_is_offered_where_it_can_stand(index: Index) -> None:
    uses = index.graphs["video_prior"]
    assert "plane=plane.prior" not in override_candidates("plane=", uses, index)
    assert "prior=plane.prior" in override_candidates("prior=", uses, index)
    assert "behind+=plane.prior" in override_candidates("behind+=", uses, index)


def test_values_that_can_be_listed_are_accepted(index: Index) -> None:
    uses = index.graphs["corridor_ccw"]
    for text in ("plane.rule=", "robot.map=", "plane.centred=", "run.record="):
        offered = list(override_candidates(text, uses, index))
        assert len(offered) > 1
        for override in offered:
            load_graph("corridor_ccw", Catalog(), [Override.parse(override)])


def test_the_stages_of_a_file_are_known_without_running_it(tmp_path: Path, index: Index) -> None:
    (tmp_path / "bad.py").write_text("raise SystemExit('imported')\n")
    graph = tmp_path / "graph.yaml"
    graph.write_text("extends: corridor_ccw\nplugins: [bad.py]\nstages:\n  twin: {use: bad.stage}\n  drive: null\n")
    found = stages_of([str(graph)], index)
    assert found["twin"] == "bad.stage"
    assert found["plane"] == "plane.ica"
    assert "drive" not in found
    assert stages_of([str(tmp_path / "gone.yaml"), str(tmp_path)], index) == {}


def test_the_index_is_kept_until_a_package_changes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = installed_index()
    file = cache_file()
    assert file is not None
    kept = file.read_bytes()
    assert installed_index() == first
    file.write_bytes(kept.replace(b"plane.ica", b"plane.old"))
    assert "plane.old" in installed_index().params
    file.write_bytes(kept.replace(b"graphnav_plane ", b"graphnav_plane 1"))
    assert installed_index() == first
    file.write_bytes(kept[:100])
    assert installed_index() == first


def test_a_cache_that_cannot_be_written_costs_only_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert "plane.ica" in installed_index().params


def test_tab_loads_no_numpy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    installed_index()
    line = "graphnav run corridor_ccw --set plane=plane.a"
    asked = {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_IFS": "\n",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(tmp_path / "out"),
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
        "PYTHONPROFILEIMPORTTIME": "1",
    }
    done = subprocess.run(PROGRAM, env={**os.environ, **asked}, capture_output=True, text=True, check=False)
    assert (tmp_path / "out").read_text().split() == [
        "plane=plane.affine",
        "plane=plane.all_ground",
        "plane=plane.appearance",
    ]
    imported = {words[-1].strip() for words in (line.split("|") for line in done.stderr.splitlines())}
    assert "argcomplete" in imported
    assert not imported & {"numpy", "yaml", "matplotlib", "jinja2"}
