"""An announced graph is drawn as ``graphnav draw`` draws it, and anything else that is announced does no harm."""

from __future__ import annotations

import json
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav.core.catalog import Catalog
from graphnav.core.errors import UserError
from graphnav.core.graph import load_graph, shipped_graphs
from graphnav.core.messages import About
from graphnav.core.render import AnnouncedGraph
from graphnav.core.render.boxes import boxes_of
from graphnav.core.render.geometry import geometry_of
from graphnav.core.runner.recording.run_recorded import about_of
from graphnav.watch.view.content.graph_layout import layout_of

CATALOG = Catalog()


@pytest.mark.parametrize("name", shipped_graphs())
def test_a_shipped_graph_is_drawn_as_draw_does(name: str) -> None:
    graph = load_graph(name, CATALOG)
    drawn, announced = geometry_of(boxes_of(graph)), geometry_of(AnnouncedGraph.read(about_of(graph), CATALOG).boxes)
    assert [(b.box.key, b.box.use, b.x, b.y, b.height) for b in announced.boxes.values()] == [
        (b.box.key, b.box.use, b.x, b.y, b.height) for b in drawn.boxes.values()
    ]
    assert [(w.path, w.wire.latest, w.colour) for w in announced.wires] == [
        (w.path, w.wire.latest, w.colour) for w in drawn.wires
    ]


def said(graph: Any, channels: tuple[str, ...] = ()) -> About:
    """Return an announcement; JSON is YAML."""
    return About(json.dumps(graph), "", "run", 7, channels, ("",) * len(channels))


def test_stages_that_are_not_installed_are_drawn_from_their_wires() -> None:
    graph = {"stages": {"a": {"use": "my.camera"}, "b": {"use": "my.finder", "in": {"image": "a.image"}}}}
    layout = layout_of(said(graph, ("a.image", "b.found")), CATALOG)
    assert [box["key"] for box in layout["boxes"]] == ["a", "b"]
    assert [(wire["ref"], wire["reader"]) for wire in layout["wires"]] == [("a.image", "b.image")]


def test_inputs_and_outputs_are_known_by_both_of_their_names() -> None:
    graph = {
        "stages": {"guard": {"use": "control.guard", "in": {"command": "teleop.twist"}}},
        "inputs": {"teleop.twist": {"channel": "TELEOP", "type": "graphnav_lcm.twist_t"}},
        "outputs": {"guard.twist": {"channel": "BASE", "type": "graphnav_lcm.twist_t", "motor": True}},
    }
    found = AnnouncedGraph.read(said(graph), CATALOG)
    assert found.names["teleop.twist"] == ("teleop.twist", "TELEOP")
    assert found.names["guard.twist"] == ("guard.twist", "BASE")
    assert [box.use for box in found.boxes] == ["input", "control.guard", "motor output"]


def test_no_plugin_file_of_an_announcement_is_run(tmp_path: Any) -> None:
    plugin = tmp_path / "plugin.py"
    plugin.write_text("raise SystemExit('run')\n")
    graph = {"plugins": [str(plugin)], "stages": {"a": {"use": "plugin.a"}}}
    assert [box.key for box in AnnouncedGraph.read(said(graph), CATALOG).boxes] == ["a"]


def test_no_file_that_an_announcement_extends_is_read(tmp_path: Any) -> None:
    (tmp_path / "other.yaml").write_text("stages: {b: {use: my.own}}\n")
    graph = {"extends": str(tmp_path / "other.yaml"), "stages": {"a": {"use": "my.own"}}}
    assert [box.key for box in AnnouncedGraph.read(said(graph), CATALOG).boxes] == ["a"]


def test_what_is_wrong_in_an_announcement_is_left_out() -> None:
    graph = {
        "stages": {"a": {"use": 7, "in": {"image": [], "flow": "b.flow"}}, "b": "my.own", "c": {}},
        "inputs": {"camera.image": {"channel": 3}},
        "outputs": {"a.twist": {"channel": [], "motor": "yes"}},
        "channels": {"a.image": None},
    }
    boxes = AnnouncedGraph.read(said(graph, ("a.image",)), CATALOG).boxes
    assert [(box.key, box.name, box.use) for box in boxes] == [
        ("camera", "camera", "input"),
        ("a", "a", ""),
        ("output a.twist", "a.twist", "output"),
    ]


@pytest.mark.parametrize(
    "graph",
    [None, 7, [], {}, {"stages": []}, {"stages": {}}, {"stages": {f"s{k}": {"use": "a.b"} for k in range(201)}}],
)
def test_what_is_not_a_graph_is_refused(graph: Any) -> None:
    with pytest.raises(UserError):
        AnnouncedGraph.read(said(graph), CATALOG)


NAMES = st.sampled_from(["a", "b", "c.d", "a.image", "output a", "", "x" * 200]) | st.text(max_size=5)
ANYTHING = st.none() | st.booleans() | st.integers() | NAMES | st.dictionaries(NAMES, NAMES, max_size=3)
REFS = st.sampled_from(["a.image", "b.x", "c.d.y", "a.", ".a", "a"]) | NAMES
STAGES = st.dictionaries(
    NAMES,
    ANYTHING
    | st.fixed_dictionaries(
        {},
        optional={
            "use": st.sampled_from(["plane.ica", "my.own", "nothing"]) | ANYTHING,
            "in": ANYTHING | st.dictionaries(NAMES, REFS, max_size=3),
        },
    ),
    max_size=5,
)
SECTION = ANYTHING | st.dictionaries(REFS, ANYTHING | st.fixed_dictionaries({"channel": NAMES}), max_size=3)


@settings(deadline=None)
@given(
    st.fixed_dictionaries({"stages": STAGES}, optional={"inputs": SECTION, "outputs": SECTION, "channels": SECTION}),
    st.lists(REFS, max_size=4),
)
def test_every_announcement_is_laid_out_or_refused(graph: Any, channels: list[str]) -> None:
    with suppress(UserError):
        json.dumps(layout_of(said(graph, tuple(channels)), CATALOG), allow_nan=False)
