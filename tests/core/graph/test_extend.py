"""A graph that extends another says only what differs; a changed ``use`` does what ``--set`` would do."""

from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Problem, UserError
from graphnav.core.graph import Graph, Override, load_graph, resolved_yaml
from graphnav.core.graph.read.extend import merge_files
from graphnav.core.graph.read.graph_files import GraphFile
from graphnav.core.spec import parse_yaml
from graphnav.core.trust import Trust

BASE = """\
stages:
  robot: {use: toy.robot, in: {command: wheels.twist}}
  flow: {use: toy.matcher, with: {layers: 5}, in: {image: robot.image}}
  smooth: {use: toy.smooth, in: {flow: flow}}
  plane: {use: toy.detector, with: {rule: otsu, model: a.bin}, in: {flow: smooth}}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
  score: {use: toy.score, in: {plane: plane, motion: robot.motion}}
channels: {smooth.flow: SMOOTH, robot.image: CAMERA}
"""

Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Return a function that writes files of graphs and returns the path of the last one."""

    def written(**texts: str) -> Path:
        for name, text in texts.items():
            (tmp_path / f"{name}.yaml").write_text(text)
        return tmp_path / f"{name}.yaml"

    return written


def meaning(graph: Graph) -> object:
    """Return what a graph does, whichever file says it."""
    nodes = [(n.name, n.use, dict(n.params), [(i.port, i.channel) for i in n.inputs]) for n in graph.nodes]
    return nodes, [n.name for n in graph.order], graph.channels, graph.run


def merged(*texts: str) -> tuple[object, list[Problem]]:
    """Return the merged content of files without places, and the problems."""
    files = [
        GraphFile(parse_yaml(t.encode(), f"{n}.yaml")[0], Path(f"{n}.yaml"), f"{n}.yaml") for n, t in enumerate(texts)
    ]
    problems: list[Problem] = []
    return merge_files(files, Catalog(), problems, []).value.plain(), problems


@pytest.mark.parametrize(
    ("use", "words"),
    [
        ("toy.guess", {}),
        ("toy.guess", {"share": 0.25}),
        ("toy.taught", {}),
        ("toy.taught", {"model": "b.bin"}),
        ("toy.detector", {"strict": "true"}),
    ],
)
def test_a_changed_use_is_a_swap(toys: Catalog, write: Write, use: str, words: dict[str, object]) -> None:
    given = ", ".join(f"{name}: {value}" for name, value in words.items())
    over = f"extends: base\nstages: {{plane: {{use: {use}, with: {{{given}}}}}}}"
    extended = load_graph(write(base=BASE, over=over), toys)
    sets = [f"plane={use}", *(f"plane.{name}={value}" for name, value in words.items() if name != "model")]
    if "model" in words:
        sets.append(f"plane.model={write(over=over).parent / 'b.bin'}")
    swapped = load_graph(write(base=BASE), toys, [*map(Override.parse, sets)])
    assert meaning(extended) == meaning(swapped)
    told = [notice for notice in swapped.notices if "already" not in notice and "in lockstep" not in notice]
    assert list(extended.file_notices) == told
    assert [notice for notice in extended.notices if "in lockstep" not in notice] == []


def test_a_file_without_words_of_its_own_is_the_graph_that_it_extends(toys: Catalog, write: Write) -> None:
    assert meaning(load_graph(write(base=BASE, over="extends: base.yaml"), toys)) == meaning(
        load_graph(write(base=BASE), toys)
    )


def test_a_graph_that_ships_is_extended_by_its_name(write: Write) -> None:
    path = write(mine="extends: corridor_ccw\nrun: {until_s: 3}\nstages: {heading: null}")
    graph = load_graph(path, Catalog())
    shipped = load_graph("corridor_ccw", Catalog())
    assert [node.name for node in graph.nodes] == [n.name for n in shipped.nodes if n.name != "heading"]
    assert graph.node("robot").params == shipped.node("robot").params
    assert (graph.run.until_s, graph.run.seed) == (3.0, shipped.run.seed)
    assert graph.about == shipped.about


def test_a_path_is_relative_to_the_file_that_it_is_written_in(
    toys: Catalog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "base.yaml").write_text(BASE)
    (tmp_path / "mine.yaml").write_text(
        "extends: lib/base.yaml\nstages:\n  robot: {with: {map: b.yaml}}\n"
        "  twin: {use: toy.taught, with: {model: a.bin}, in: {flow: flow.flow}}\n"
    )
    for folder in (tmp_path, tmp_path.parent):
        monkeypatch.chdir(folder)
        graph = load_graph(tmp_path / "mine.yaml", toys)
        assert graph.node("plane").params["model"] == tmp_path / "lib" / "a.bin"
        assert graph.node("twin").params["model"] == tmp_path / "a.bin"
        assert graph.node("robot").params["map"] == tmp_path / "b.yaml"


def test_the_last_file_of_a_chain_wins(toys: Catalog, write: Write) -> None:
    path = write(
        base=BASE,
        second="extends: base\nrun: {seed: 2, until_s: 5}\nstages: {plane: {use: toy.guess}, score: null}",
        third="extends: second\nrun: {seed: 3}\nstages:\n  plane: {use: toy.taught, in: {flow: robot.flow}}\n"
        "  score: {use: toy.score, in: {plane: plane}}\n  robot: {use: toy.sees}\n",
    )
    with pytest.raises(UserError, match="family 'toy' has no stage 'sees'") as caught:
        load_graph(path, toys)
    assert {problem.place.line for problem in caught.value.problems if problem.place} == {6}
    path.write_text(path.read_text().replace("  robot: {use: toy.sees}\n", "").replace("robot.flow", "flow.flow"))
    graph = load_graph(path, toys)
    assert (graph.run.seed, graph.run.until_s) == (3, 5.0)
    assert (graph.node("plane").use, graph.node("plane").params["model"].name) == ("toy.taught", "a.bin")
    assert [i.channel for i in graph.node("score").inputs][1] is None, "it was removed and added again"


def test_stages_keep_their_order_and_new_ones_come_last(toys: Catalog, write: Write) -> None:
    over = "extends: base\nstages:\n  twin: {use: toy.detector, in: {flow: flow}}\n  robot: {with: {noise_px: 1}}\n"
    graph = load_graph(write(base=BASE, over=over), toys)
    assert [node.name for node in graph.nodes] == ["robot", "flow", "smooth", "plane", "wheels", "score", "twin"]


def test_where_a_graph_lies_is_not_in_its_text(toys: Catalog, write: Write, tmp_path: Path) -> None:
    over = "extends: base\nstages: {plane: {use: toy.taught}, smooth: {with: {alpha: 0.25}}}"
    assert str(tmp_path) not in resolved_yaml(load_graph(write(base=BASE, over=over), toys))


def test_swaps_of_the_command_line_come_last(toys: Catalog, write: Write) -> None:
    over = "extends: base\nstages: {plane: {use: toy.guess, with: {share: 0.25}}}"
    graph = load_graph(write(base=BASE, over=over), toys, [*map(Override.parse, ("plane.share=0.75", "run.seed=8"))])
    assert (graph.node("plane").params["share"], graph.run.seed) == (0.75, 8)


SECTIONS = """\
inputs: {camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}, odometry.odometry: {log: drive.lcmlog}}
outputs: {guard.twist: {channel: BASE, motor: true, stop: {v: 0, omega: 0}}}
queues: {plane.flow: {keep: 4}, steer.plane: {keep: all}}
channels: {a.b: A, c.d: C}
run: {seed: 3, until_s: 4}
"""


def test_sections_are_merged_key_by_key() -> None:
    value, problems = merged(
        SECTIONS,
        """\
        inputs: {camera.image: {max_age_s: 0.5, channel: CAM}, odometry.odometry: null, beacon.goal: {channel: B}}
        outputs: {guard.twist: {stop: {omega: null, turn: 1}}}
        queues: {plane.flow: {keep: all}, steer.plane: null}
        channels: {a.b: null}
        run: {until_s: null}
        """,
    )
    assert problems == []
    assert value == {
        "inputs": {
            "camera.image": {"channel": "CAM", "type": "graphnav_lcm.image_t", "max_age_s": 0.5},
            "beacon.goal": {"channel": "B"},
        },
        "outputs": {"guard.twist": {"channel": "BASE", "motor": True, "stop": {"v": 0, "turn": 1}}},
        "queues": {"plane.flow": {"keep": "all"}},
        "channels": {"c.d": "C"},
        "run": {"seed": 3, "until_s": None},
    }


def test_an_empty_section_changes_nothing() -> None:
    keys = ("inputs", "outputs", "queues", "channels", "run", "stages")
    base = SECTIONS + "stages: {robot: {use: toy.robot, every_ms: 50}}\n"
    assert merged(base, "".join(f"{key}:\n" for key in keys))[0] == merged(base)[0]


def test_what_else_is_said_of_a_stage_is_replaced_and_null_takes_it_away() -> None:
    base = "stages: {plane: {use: a.b, every_ms: 50, deadline_ms: 20, with: {x: 1, y: 2}}}"
    value, problems = merged(base, "stages: {plane: {every_ms: 20, deadline_ms: null, with: {x: null}}}")
    assert problems == []
    assert value == {"stages": {"plane": {"use": "a.b", "every_ms": 20, "with": {"x": None, "y": 2}}}}


LIVE = """\
inputs: {camera.image: {channel: CAMERA, type: graphnav_lcm.image_t, max_age_s: 0.5}}
outputs: {plane.plane: {channel: PLANE}}
stages:
  flow: {use: toy.matcher, in: {image: camera}}
  plane: {use: toy.detector, every_ms: 50, in: {flow: flow.flow}}
"""


def test_a_live_graph_is_extended(toys: Catalog, write: Write) -> None:
    over = """\
extends: live
inputs: {camera.image: {channel: FRONT}}
outputs: {plane.plane: {type: graphnav_lcm.plane_t}}
queues: {plane.flow: {keep: 4}}
stages: {plane: {every_ms: 20, deadline_ms: 10}}
"""
    graph = load_graph(write(live=LIVE, mine=over), toys)
    camera, sent, plane = graph.inputs["camera.image"], graph.outputs["plane.plane"], graph.node("plane")
    assert (camera.name, camera.type_name, camera.max_age_s) == ("FRONT", "graphnav_lcm.image_t", 0.5)
    assert (sent.name, sent.type_name, graph.queues) == ("PLANE", "graphnav_lcm.plane_t", {"plane.flow": 4})
    assert (plane.every_ms, plane.deadline_ms) == (20, 10)


def test_inputs_give_way_to_a_world(toys: Catalog, write: Write) -> None:
    over = """\
extends: live
inputs: {camera.image: null}
outputs: {plane.plane: null}
stages:
  robot: {use: toy.robot}
  flow: {in: {image: robot.image}}
  plane: {every_ms: null}
"""
    graph = load_graph(write(live=LIVE, mine=over), toys)
    assert (graph.is_live, graph.outputs) == (False, {})
    assert [source.name for source in graph.sources] == ["robot"]
    assert graph.node("plane").every_ms is None


def test_plugins_of_all_files_are_loaded(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    for path, name in ((tmp_path / "lib" / "one.py", "One"), (tmp_path / "two.py", "Two")):
        path.write_text(
            f"from graphnav import Image, Source, hookimpl\n\n\nclass {name}(Source):\n"
            "    def step(self) -> Image:\n        raise NotImplementedError\n\n\n"
            f"@hookimpl\ndef graphnav_stages():\n    return [{name}]\n"
        )
    (tmp_path / "lib" / "base.yaml").write_text("plugins: [one.py]\nstages: {first: {use: one.one}}")
    (tmp_path / "mine.yaml").write_text(
        "extends: lib/base.yaml\nplugins: [two.py, ./lib/../two.py]\nstages: {second: {use: two.two}}"
    )
    graph = load_graph(tmp_path / "mine.yaml", Catalog(Trust(runs_all=True)))
    assert graph.plugins == (tmp_path / "lib" / "one.py", tmp_path / "two.py")
    assert graph.written_plugins == ("one.py", "two.py")


PARTS = """\
stages:
  smooth: null
  plane: {use: toy.taught, with: {model: b.bin}, in: {flow: flow.flow}}
"""


def test_each_of_a_list_overrides_those_before_it(toys: Catalog, write: Write) -> None:
    chain = load_graph(write(base=BASE, parts="extends: base\n" + PARTS, over="extends: parts"), toys)
    listed = load_graph(write(base=BASE, parts=PARTS, over="extends: [base, parts]"), toys)
    assert meaning(listed) == meaning(chain)
    assert listed.notices == chain.notices
    other = load_graph(write(base=BASE, a=WORDS.format(2), b=WORDS.format(3), over="extends: [base, b, a]"), toys)
    assert other.node("flow").params["layers"] == 2


WORDS = "stages: {{flow: {{with: {{layers: {}}}}}}}"


def test_a_file_that_several_extend_is_read_once_and_first(toys: Catalog, write: Write) -> None:
    changes, parts = f"extends: base\n{WORDS.format(3)}", "extends: base\nchannels: {smooth.flow: OTHER}"
    graph = load_graph(write(base=BASE, changes=changes, parts=parts, over="extends: [changes, parts]"), toys)
    assert graph.node("flow").params["layers"] == 3, "the base does not override what changes it"
    assert [graph.channels[ref].name for ref in ("smooth.flow", "robot.image")] == ["OTHER", "CAMERA"]


def test_the_resolved_graph_of_a_list_is_the_same_graph(toys: Catalog, write: Write) -> None:
    graph = load_graph(write(base=BASE, parts=PARTS, over="extends: [base, parts]\nrun: {seed: 3}"), toys)
    text = resolved_yaml(graph)
    assert "extends" not in text
    assert meaning(load_graph(write(resolved=text), toys)) == meaning(graph)


def test_parts_that_ship_are_extended_by_their_name(write: Write) -> None:
    graph = load_graph(write(mine="extends: [corridor_ccw, parts/navigate]"), Catalog())
    assert graph.node("steer").use == "steer.frontier"
    assert graph.node("robot").params["map"] == load_graph("corridor_ccw", Catalog()).node("robot").params["map"]
