"""``plugins:`` of a graph: loaded first, relative to the graph, each file once."""

from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import UserError
from graphnav.core.graph import Override, load_graph, resolved_yaml
from graphnav.core.trust import Trust

PLUGIN = """
from graphnav import Source, Stage, Twist, hookimpl, param


class Still(Source):
    speed_mps: float = param(0.0, doc="the speed of all commands")

    def step(self) -> Twist:
        return Twist(v_mps=self.speed_mps, omega_radps=0.0)


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Still]
"""
TRUST = Trust(runs_all=True)
GRAPH = "plugins: [stages/mine.py]\nstages: {wheels: {use: mine.still}}\n"


@pytest.fixture
def graph(tmp_path: Path) -> Path:
    """Return a graph that names a plugin in a folder beside it."""
    (tmp_path / "stages").mkdir()
    (tmp_path / "stages" / "mine.py").write_text(PLUGIN)
    (tmp_path / "graph.yaml").write_text(GRAPH)
    return tmp_path / "graph.yaml"


def test_its_stages_are_there_for_the_graph_and_for_swaps(graph: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir("/")
    loaded = load_graph(graph, Catalog(TRUST), [*map(Override.parse, ("again+=mine.still", "again.speed_mps=1"))])
    assert loaded.node("wheels").params == {"rate_hz": 10.0, "speed_mps": 0.0}
    assert loaded.node("again").params["speed_mps"] == 1.0
    assert (loaded.plugins, loaded.written_plugins) == ((graph.parent / "stages" / "mine.py",), ("stages/mine.py",))


def test_a_file_given_twice_is_one(graph: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(graph.parent)
    catalog = Catalog(TRUST)
    catalog.add_file(Path("stages/mine.py"))
    (graph.parent / "linked.py").symlink_to("stages/mine.py")
    graph.write_text(GRAPH.replace("[stages/mine.py]", "[stages/mine.py, linked.py]"))
    assert load_graph("graph.yaml", catalog).plugins == (graph.parent / "stages" / "mine.py",)


def test_the_text_names_it_as_the_graph_does(graph: Path) -> None:
    loaded = load_graph(graph, Catalog(TRUST))
    assert "plugins: [stages/mine.py]\n" in resolved_yaml(loaded)
    assert f"plugins: [{graph.parent}/stages/mine.py]\n" in resolved_yaml(loaded, portable_paths=False)


def test_what_its_stages_lack_is_not_told_when_it_cannot_be_used(graph: Path) -> None:
    (graph.parent / "stages" / "mine.py").write_text("def\n")
    graph.write_text(GRAPH + "channel: {}\n")
    with pytest.raises(UserError) as caught:
        load_graph(graph, Catalog(TRUST))
    assert [problem.what.partition(":")[0] for problem in caught.value.problems] == [
        f"plugin {graph.parent}/stages/mine.py",
        "a graph has no key 'channel'",
    ]


@pytest.mark.parametrize("name", ["x" * 300, "a\\0b", "~nobody/x.py", "", "..", "/"])
def test_a_path_that_cannot_be_one_is_a_users_error(graph: Path, name: str) -> None:
    graph.write_text(GRAPH.replace("stages/mine.py", f'"{name}"'))
    with pytest.raises(UserError):
        load_graph(graph, Catalog(TRUST))
