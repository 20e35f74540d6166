"""Records of older versions are read with names of parameters that a graph may no longer use."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import pytest

from graphnav.core.codec import decode, encode
from graphnav.core.errors import UserError
from graphnav.core.graph import load_graph
from graphnav.core.messages import About
from graphnav.core.record import LogWriter, Recording
from graphnav.core.run_folder import RunFolder
from tests.replay.conftest import LOOP, Made, Record, catalog

HINT = "did you mean 'offset'? It was renamed"


def of_older_version(log: Path) -> Path:
    """Return a copy of a run folder whose graph and log use the old name of ``offset``; its log."""
    folder = log.parent.with_name("older")
    folder.mkdir()
    saved = (log.parent / RunFolder.GRAPH).read_text()
    assert "offset:" in saved
    (folder / RunFolder.GRAPH).write_text(saved.replace("offset:", "shift:"))
    with Recording(log) as recording, LogWriter(folder / log.name) as writer:
        for event in recording.events():
            data = event.data
            if event.channel == About.CHANNEL:
                utime, seq, about = decode(About, data)
                older = dataclasses.replace(about, graph_yaml=about.graph_yaml.replace("offset:", "shift:"))
                data = encode(older, utime, seq)
            writer.write(event.channel, event.utime, data)
    return folder / log.name


@pytest.fixture
def older(record: Record) -> Path:
    """Return the log of a run with ``offset: 3`` as an older version would have written it."""
    return of_older_version(record(LOOP, "mean.offset=3"))


def test_a_log_with_an_old_name_is_replayed(older: Path, made: Made, tmp_path: Path) -> None:
    alone = tmp_path / "alone.lcmlog"
    shutil.copy(older, alone)
    for log in (older, alone):
        params = next(node.params for node in made(log).graph.nodes if node.name == "mean")
        assert params["offset"] == 3.0


def test_a_run_folder_with_an_old_name_runs_again(older: Path) -> None:
    graph = load_graph(older.parent / RunFolder.GRAPH, catalog())
    assert next(node.params for node in graph.nodes if node.name == "mean")["offset"] == 3.0


def test_a_graph_with_an_old_name_is_refused_with_the_new_one(older: Path, tmp_path: Path) -> None:
    written = tmp_path / "written.yaml"
    shutil.copy(older.parent / RunFolder.GRAPH, written)
    with pytest.raises(UserError) as caught:
        load_graph(written, catalog())
    assert [(p.what, str(p.hint)) for p in caught.value.problems] == [("again.mean has no parameter 'shift'", HINT)]


def test_set_with_an_old_name_is_refused_even_for_a_record(older: Path, made: Made) -> None:
    with pytest.raises(UserError) as caught:
        made(older, "mean.shift=1")
    assert [str(problem.hint) for problem in caught.value.problems] == [HINT]
