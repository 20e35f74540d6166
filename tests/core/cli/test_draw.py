"""Drawings show every stage and every wire, in the terminal and for other programs."""

import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.graph import Graph, graph_of, resolved_yaml
from graphnav.core.render import dot_of, mermaid_of, svg_of, text_of

SVG = "{http://www.w3.org/2000/svg}"
TOYS = Path(__file__).parent.parent.parent / "errors" / "stages.py"

TERMINAL = """\
┌──────────────────────┐
│ robot      toy.robot │
│   ◂ command (latest) │◂╌╌╌╌╮
│   ▸ image: Image     ├──╮  │
│   ▸ motion: Motion   ├──┼──┼──╮
└──────────────────────┘  │  │  │
┌──────────────────────┐  │  │  │
│ flow     toy.matcher │  │  │  │
│   ◂ image            │◂─╯  │  │
│   ▸ flow: Flow       ├──╮  │  │
└──────────────────────┘  │  │  │
┌──────────────────────┐  │  │  │
│ plane   toy.detector │  │  │  │
│   ◂ flow             │◂─╯  │  │
│   ▸ plane: Plane     ├──╮  │  │
└──────────────────────┘  │  │  │
┌──────────────────────┐  │  │  │
│ wheels    toy.wheels │  │  │  │
│   ◂ plane            │◂─┤  │  │
│   ▸ twist: Twist     ├──┼──╯  │
└──────────────────────┘  │     │
┌──────────────────────┐  │     │
│ score      toy.score │  │     │
│   ◂ plane            │◂─╯     │
│   ◂ motion (latest)  │◂╌╌╌╌╌╌╌╯
└──────────────────────┘
"""


def test_the_terminal_shows_boxes_and_rails(load: Callable[..., Graph]) -> None:
    assert str(text_of(load())) == TERMINAL


def wires(graph: Graph) -> list[tuple[str, str, bool]]:
    return [
        (i.channel.ref, f"{n.name}.{i.port.name}", i.port.latest) for n in graph.nodes for i in n.inputs if i.channel
    ]


def test_svg_is_xml_with_a_box_for_each_stage_and_a_line_for_each_wire(load: Callable[..., Graph]) -> None:
    graph = load()
    tree = ET.fromstring(svg_of(graph))
    names = [text.text for text in tree.iter(f"{SVG}text") if text.get("class") == "name"]
    assert sorted(map(str, names)) == sorted(node.name for node in graph.nodes)
    lines = [path for path in tree.iter(f"{SVG}path") if (path.get("class") or "").startswith("wire")]
    assert len(lines) == len(wires(graph))
    assert sum(line.get("class") == "wire sampled" for line in lines) == sum(latest for *_, latest in wires(graph))


def test_mermaid_and_dot_have_every_wire(load: Callable[..., Graph]) -> None:
    graph = load()
    mermaid, dot = mermaid_of(graph), dot_of(graph)
    for writer, reader, latest in wires(graph):
        (start, port), (end, entry) = writer.split("."), reader.split(".")
        assert f's_{start} {"-.->" if latest else "-->"}|"{port}"| s_{end}\n' in mermaid
        assert f'"{start}":"out_{port}":e -> "{end}":"in_{entry}":w' in dot


LIVE = """\
inputs: {camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}}
stages:
  flow: {use: toy.matcher, in: {image: camera.image}}
  plane: {use: toy.detector, in: {flow: flow.flow}}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
  guard: {use: toy.guard, every_ms: 50, in: {command: wheels.twist, plane: plane.plane}}
outputs: {guard.twist: {channel: 'BASE|"<CMD>', motor: true}}
"""


def test_the_terminal_shows_what_comes_in_and_leaves(load: Callable[..., Graph]) -> None:
    lines = str(text_of(load(LIVE))).splitlines()
    assert lines[1].split("│")[1].split() == ["camera", "input"]
    assert "▸ image: Image from CAMERA" in lines[2]
    assert lines[-3].split("│")[1].split() == ['BASE|"<CMD>', "motor", "output"]
    assert "◂ twist" in lines[-2]


def test_other_programs_show_what_comes_in_and_leaves(load: Callable[..., Graph]) -> None:
    graph = load(LIVE)
    tree = ET.fromstring(svg_of(graph))
    names = [str(text.text) for text in tree.iter(f"{SVG}text") if text.get("class") == "name"]
    assert sorted(names) == sorted(["camera", *(node.name for node in graph.nodes), 'BASE|"<CMD>'])
    lines = [path for path in tree.iter(f"{SVG}path") if (path.get("class") or "").startswith("wire")]
    assert len(lines) == len(wires(graph)) + 1
    assert [tspan.text for tspan in tree.iter(f"{SVG}tspan")] == ["CAMERA"]
    mermaid, dot = mermaid_of(graph), dot_of(graph)
    assert 's_camera[/"<b>camera (CAMERA)</b><br/>input"/]' in mermaid
    assert 's_guard -->|"twist"| s_output_guard_twist' in mermaid
    assert '"guard":"out_twist":e -> "output_guard.twist":"in_twist":w' in dot
    assert 'label="{BASE\\|\\"\\<CMD\\>\\nmotor output|{{<in_twist> twist}|{}}}"' in dot


CHAINS = st.lists(st.tuples(st.integers(0, 20), st.integers(0, 20)), max_size=10)


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(CHAINS)
def test_any_graph_is_drawn_without_lines_that_cross_boxes_or_meet_others(
    toys: Catalog, reads: list[tuple[int, int]]
) -> None:
    lines = ["stages:", "  robot: {use: toy.robot}", "  m0: {use: toy.matcher, in: {image: robot.image}}"]
    for number, (one, other) in enumerate(reads, start=1):
        wires = f"first: m{one % number}.flow, second: m{other % number}.flow"
        lines.append(f"  m{number}: {{use: toy.mix, in: {{{wires}}}}}")
    graph = graph_of("\n".join(lines).encode(), Path("graph.yaml"), toys)
    drawing = text_of(graph)
    heads = sum(line.count("◂") - line.count("  ◂ ") for line in drawing.lines)
    assert heads == sum(i.channel is not None for node in graph.nodes for i in node.inputs)
    assert all(len(line) <= len(rails) for line, rails in zip(drawing.lines, drawing.rails, strict=True))
    for format_of in (svg_of, mermaid_of, dot_of):
        assert format_of(graph)


@pytest.mark.parametrize("kind", ["text", "svg", "mermaid", "dot"])
def test_the_command_writes_a_file_or_to_the_terminal(
    kind: str, load: Callable[..., Graph], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "graph.yaml").write_text(resolved_yaml(load()))
    words = ["draw", str(tmp_path / "graph.yaml"), "--plugin", str(TOYS), "--format", kind]
    assert main(words) == 0
    said = capsys.readouterr().out
    assert "wheels" in said
    assert main([*words, "-o", str(tmp_path / "drawing")]) == 0
    assert (tmp_path / "drawing").read_text() == said


def test_a_file_that_cannot_be_written_is_told(
    load: Callable[..., Graph], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "graph.yaml").write_text(resolved_yaml(load()))
    nowhere = tmp_path / "no" / "where.svg"
    words = ["draw", str(tmp_path / "graph.yaml"), "--plugin", str(TOYS), "--format", "svg", "-o", str(nowhere)]
    assert main(words) == 2
    assert capsys.readouterr().err == (
        f"cannot write {nowhere}: No such file or directory\n  choose another file with -o\n"
    )
