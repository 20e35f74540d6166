"""Paths resolve against the graph's folder, those of --set against the working folder, then against what ships."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from graphnav.core.graph import Graph, resolved_yaml, shipped_folder
from graphnav.core.graph.paths import has_path, resolve_paths

Load = Callable[..., Graph]
GRAPH = "stages:\n  robot: {use: toy.robot, with: {map: PATH}}\n"
SHIPPED = "maps/corridor_ccw.yaml"


def map_of(graph: Graph) -> Any:
    return graph.node("robot").params["map"]


def test_beside_the_graph(load: Load, tmp_path: Path) -> None:
    (tmp_path / "here.yaml").touch()
    assert map_of(load(GRAPH.replace("PATH", "here.yaml"))) == tmp_path / "here.yaml"


def test_set_means_the_working_folder(load: Load, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "here.yaml").touch()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "here.yaml").touch()
    monkeypatch.chdir(tmp_path / "elsewhere")
    graph = load(GRAPH.replace("PATH", "other.yaml"), "robot.map=here.yaml")
    assert map_of(graph) == tmp_path / "elsewhere" / "here.yaml"


def test_then_what_ships(load: Load) -> None:
    found = map_of(load(GRAPH.replace("PATH", SHIPPED)))
    assert found == shipped_folder() / SHIPPED
    assert f"map: {SHIPPED}\n" in resolved_yaml(load(GRAPH.replace("PATH", SHIPPED)), portable_paths=False)


def test_what_is_beside_the_graph_comes_before_what_ships(load: Load, tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    (tmp_path / SHIPPED).touch()
    assert map_of(load(GRAPH.replace("PATH", SHIPPED))) == tmp_path / SHIPPED


def test_what_is_missing_is_meant_beside_the_graph(load: Load, tmp_path: Path) -> None:
    assert map_of(load(GRAPH.replace("PATH", "nowhere.yaml"))) == tmp_path / "nowhere.yaml"


def test_an_absolute_path_stays(load: Load) -> None:
    assert map_of(load(GRAPH.replace("PATH", "/nowhere/x.yaml"))) == Path("/nowhere/x.yaml")


def test_a_pattern_resolves_like_its_files(tmp_path: Path) -> None:
    (tmp_path / "frames").mkdir()
    (tmp_path / "frames" / "1.jpg").touch()
    assert resolve_paths(Path, Path("frames/*.jpg"), tmp_path).value == tmp_path / "frames" / "*.jpg"


def test_devices_and_urls_stay(tmp_path: Path) -> None:
    for path in (Path("0"), Path("rtsp://camera/1")):
        assert resolve_paths(Path, path, tmp_path).value == path


def test_paths_inside_of_lists_and_choices(tmp_path: Path) -> None:
    (tmp_path / "a").touch()
    assert has_path(Path | None)
    assert has_path(tuple[Path, ...])
    assert not has_path(tuple[int, str])
    assert resolve_paths(tuple[Path, ...], (Path("a"), Path("b")), tmp_path).value == (tmp_path / "a", tmp_path / "b")
    assert resolve_paths(Path | None, None, tmp_path).value is None
