"""A graph is found by its file or its name; what is missing is told with what is near."""

from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import UserError
from graphnav.core.graph import find_graph, load_graph, shipped_folder, shipped_graphs


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_file_in_the_working_folder_comes_before_a_graph_that_ships() -> None:
    assert find_graph("video_plane") == shipped_folder() / "video_plane.yaml"
    Path("video_plane.yaml").touch()
    assert find_graph("video_plane") == Path("video_plane.yaml")
    assert find_graph("video_plane.yaml") == Path("video_plane.yaml")


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("vidoe_plane", "did you mean 'video_plane'?"),
        ("mine.yml", "did you mean 'mine.yaml'?"),
        ("tight", "did you mean 'suite/tight'?"),
        ("suite", "it is a study; run it with 'graphnav ablate suite'"),
        ("qqqq", "that ship"),
    ],
)
def test_a_missing_graph_is_told_with_what_is_near(name: str, hint: str) -> None:
    Path("mine.yaml").touch()
    with pytest.raises(UserError) as caught:
        find_graph(name)
    assert str(caught.value).startswith(f"{name}: there is no such graph")
    assert hint in str(caught.value)


def test_a_folder_is_no_graph() -> None:
    Path("maps.yaml").mkdir()
    Path("maps.yaml/inner.yaml").touch()
    with pytest.raises(UserError, match=r"it is a folder, not a graph\n  name a file in it: inner\.yaml"):
        find_graph("maps.yaml")


@pytest.mark.parametrize("name", ["x" * 5000, "x" * 5000 + "/y", "a\0b", ""])
def test_a_name_that_no_file_can_have_is_missing(name: str) -> None:
    with pytest.raises(UserError):
        find_graph(name)


def test_errors_name_a_file_from_the_working_folder(toys: Catalog, tmp_path: Path) -> None:
    Path("bad.yaml").write_text("stagse: {}\n")
    with pytest.raises(UserError) as caught:
        load_graph(tmp_path / "bad.yaml", toys)
    assert str(caught.value).startswith("bad.yaml:1:1: ")


@pytest.mark.parametrize("name", sorted(shipped_graphs()))
def test_every_graph_that_ships_loads(name: str) -> None:
    graph = load_graph(name, Catalog())
    assert graph.about
    assert graph.sources or graph.inputs


def test_a_graph_in_a_folder_that_ships_is_named_by_both() -> None:
    assert find_graph("suite/doors") == shipped_graphs()["suite/doors"]
    assert not any(name.startswith(("maps/", "studies/")) for name in shipped_graphs())
