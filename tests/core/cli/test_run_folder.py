"""The folder of a run: gone where the run did not start."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphnav.core.errors import BusError
from graphnav.core.report.folder import make_run_folder, removed_if_empty


def test_a_folder_into_which_nothing_was_written_is_removed(tmp_path: Path) -> None:
    folder = make_run_folder(tmp_path / "run", "graph")
    with pytest.raises(BusError), removed_if_empty(folder):
        raise BusError("LCM cannot listen")
    assert not folder.exists()


def test_a_folder_into_which_something_was_written_stays(tmp_path: Path) -> None:
    folder = make_run_folder(tmp_path / "run", "graph")
    with removed_if_empty(folder):
        (folder / "graph.yaml").touch()
    assert [path.name for path in folder.iterdir()] == ["graph.yaml"]
