"""``graphnav.load``, ``check`` and ``draw``: what the commands say, as values."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import graphnav
from graphnav import Place, UserError
from graphnav.core.api.arguments import Argument
from graphnav.core.api.parameters import Shared
from graphnav.core.cli import main
from graphnav.core.graph import Override
from graphnav.core.machine.console import Console

TEXT = st.text(st.characters(exclude_categories=["Cs"]))
SCALARS = st.none() | st.booleans() | st.integers(-(2**40), 2**40) | st.floats(allow_nan=False, allow_infinity=False)
VALUES = SCALARS | TEXT | st.lists(SCALARS | TEXT, max_size=4)


@given(VALUES)
def test_a_value_reaches_the_graph_as_it_is(value: object) -> None:
    (override,) = Argument({"stage.parameter": value}, Shared.SET).overrides()
    read = override.entry.value.plain()
    assert (read, type(read)) == (value, type(value))
    assert override.place == Place("set['stage.parameter']")
    written = Override.parse(override.words)
    assert (written.target, written.value) == (override.target, value)


def test_values_of_numpy_and_paths_are_plain_ones(graph: Path, tmp_path: Path) -> None:
    values = {"noise_px": np.float64(0.5), "ticks": np.int64(4), "numbers": np.array([1.0, 2.5]), "name": np.str_("3")}
    loaded = graphnav.load(
        graph, set={f"sensor.{name}": value for name, value in values.items()} | {"run.until_s": None}
    )
    params = loaded.node("sensor").params
    assert (params["noise_px"], params["ticks"], params["numbers"], params["name"]) == (0.5, 4, (1.0, 2.5), "3")
    assert loaded.run.until_s is None
    assert graphnav.load(graph, set={"sensor.file": tmp_path / "x"}).node("sensor").params["file"] == tmp_path / "x"


def test_load_checks_what_parameters_name() -> None:
    with pytest.raises(UserError, match="map"):
        graphnav.load("corridor_ccw", set={"robot.map": "nowhere.yaml"})


def test_check_lists_what_the_command_prints(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert graphnav.check("corridor_ccw") == []
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text("stages:\n  robot: {use: world.pymnk}\n  flow: {use: flow.dis, in: {image: robt.image}}\n")
    problems = graphnav.check(str(wrong))
    assert main(["check", str(wrong)]) == 2
    assert capsys.readouterr().err == "\n".join(map(str, problems)) + f"\n{len(problems)} errors\n"
    assert [problem.place.line for problem in problems if problem.place] == [2, 3]
    assert [str(problem) for problem in graphnav.check("corridor_cw2")] == [
        "corridor_cw2: there is no such graph\n  did you mean 'corridor_cw'?"
    ]


def test_check_of_a_loaded_graph_looks_at_its_parameters(graph: Path) -> None:
    loaded = graphnav.load(graph)
    assert graphnav.check(loaded) == []
    with pytest.raises(UserError, match=r"^set and plugins have no effect on a loaded graph"):
        graphnav.check(loaded, set={"sensor.ticks": 3})
    with pytest.raises(UserError, match=r"^graph must be a path"):
        graphnav.check(3)  # type: ignore[arg-type]


@pytest.mark.parametrize("form", ["text", "svg", "mermaid", "dot"])
def test_a_drawing_is_what_the_command_prints(graph: Path, capsys: pytest.CaptureFixture[str], form: str) -> None:
    assert main(["draw", str(graph), "--format", form]) == 0
    drawing: Any = graphnav.draw(graph)
    assert capsys.readouterr().out == getattr(drawing, form)


def test_a_drawing_shows_itself(graph: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drawing = graphnav.draw(graphnav.load(graph))
    assert drawing._repr_svg_() == drawing._repr_html_() == drawing.svg
    assert str(drawing) == drawing.text == f"{drawing!r}\n"
    Console(soft_wrap=True, width=40).print(drawing)
    assert capsys.readouterr().out == drawing.text
