"""Whatever a file holds and whatever is set, the answer is a graph or a user's error."""

import contextlib
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graphnav.core.catalog import Catalog
from graphnav.core.errors import UserError
from graphnav.core.graph import Graph, Override, graph_of, resolved_yaml

CALM = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture])

KNOWN = """
about extends plugins run stages channels deploy inputs outputs queues use with in every_ms deadline_ms robot flow plane
wheels toy.robot toy.matcher toy.detector toy.wheels toy.idle toy.eager toy.untyped toy.taught toy image
command twist robot.image flow.flow plane.plane wheels.twist noise_px rate_hz layers model limits seed until_s
record all keep CAMERA url camera.image camera guard guard.twist toy.guard channel log type motor
stop max_age_s graphnav_lcm.image_t graphnav_lcm.twist_t toy.wheels_t toy.odometer_t udpm:// wheels.plane
"""
WORDS = st.sampled_from(KNOWN.split())
ATOMS = WORDS | st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8)
TREES = st.recursive(
    ATOMS,
    lambda tree: st.lists(tree, max_size=3) | st.dictionaries(WORDS | st.text(max_size=4), tree, max_size=4),
    max_leaves=20,
)
STAGE = st.fixed_dictionaries({"use": ATOMS}, optional={"with": TREES, "in": st.dictionaries(WORDS, ATOMS, max_size=3)})
GRAPHS = st.fixed_dictionaries(
    {"stages": st.dictionaries(WORDS, STAGE | TREES, max_size=5)},
    optional={
        **dict.fromkeys(("about", "plugins", "run", "channels", "deploy", "inputs", "outputs", "queues"), TREES),
        "inputs": st.dictionaries(WORDS, st.dictionaries(WORDS, TREES, max_size=4) | TREES, max_size=3),
        "outputs": st.dictionaries(WORDS, st.dictionaries(WORDS, TREES, max_size=5) | TREES, max_size=3),
    },
)
SECTIONS = ("run", "channels", "inputs", "outputs", "queues")
BASE = """\
stages:
  robot: {use: toy.robot, in: {command: wheels.twist}}
  flow: {use: toy.matcher, in: {image: robot.image}}
  plane: {use: toy.detector, with: {limits: [0, 1]}, in: {flow: flow}}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
channels: {flow.flow: CAMERA}
"""
OVERLAYS = st.fixed_dictionaries(
    {"extends": st.just("base")},
    optional={
        "stages": st.dictionaries(WORDS, st.none() | STAGE | TREES, max_size=5),
        **dict.fromkeys(
            ("run", "channels", "inputs", "outputs", "queues"),
            st.dictionaries(WORDS, TREES, max_size=3) | TREES,
        ),
    },
)
SETS = st.lists(
    st.builds("{}{}{}={}".format, WORDS, st.sampled_from(["", ".in.", ".", "+"]), WORDS | st.just(""), ATOMS)
    | st.text(max_size=12),
    max_size=3,
)


def is_answered(data: bytes, toys: Catalog, sets: list[str]) -> None:
    with contextlib.suppress(UserError):
        graph = graph_of(data, Path("graph.yaml"), toys, [*map(Override.parse, sets)])
        assert isinstance(graph, Graph)
        graph_of(resolved_yaml(graph).encode(), Path("graph.yaml"), toys)


@CALM
@given(st.binary(max_size=300))
def test_bytes(toys: Catalog, data: bytes) -> None:
    is_answered(data, toys, [])


@CALM
@given(st.text(max_size=300), SETS)
def test_texts(toys: Catalog, text: str, sets: list[str]) -> None:
    is_answered(text.encode("utf-8", "replace"), toys, sets)


@CALM
@given(GRAPHS, SETS)
def test_graphs_of_known_words(toys: Catalog, graph: object, sets: list[str]) -> None:
    is_answered(as_yaml(graph).encode("utf-8", "replace"), toys, sets)


@CALM
@given(GRAPHS, OVERLAYS, SETS)
def test_graphs_that_extend_one_another(
    toys: Catalog, tmp_path: Path, base: object, overlay: object, sets: list[str]
) -> None:
    for text in (BASE, as_yaml(base)):
        (tmp_path / "base.yaml").write_bytes(text.encode("utf-8", "replace"))
        data = as_yaml(overlay).encode("utf-8", "replace")
        with contextlib.suppress(UserError):
            graph = graph_of(data, tmp_path / "graph.yaml", toys, [*map(Override.parse, sets)])
            graph_of(resolved_yaml(graph).encode(), tmp_path / "graph.yaml", toys)


def as_yaml(value: object) -> str:
    """Return plain data as YAML on one line, words unquoted."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{as_yaml(key)}: {as_yaml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(as_yaml, value)) + "]"
    return "null" if value is None else str(value)


SYNTAX = "stages:|  robot|toy.robot|: |{|}|[|]|&a |*a|use|,|'|\"|#|- |>|!!int |\t|---|? |%YAML|\x00|é|\ud7ff|\n| "
PIECES = st.sampled_from([*SYNTAX.split("|"), "|"])


@CALM
@given(st.lists(PIECES))
def test_pieces_of_yaml(toys: Catalog, pieces: list[str]) -> None:
    is_answered("".join(pieces).encode(), toys, [])
