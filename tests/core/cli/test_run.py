"""``graphnav run``: what it prints for programs, and options that it refuses."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from graphnav.core.cli import main

PLUGIN = """
from collections.abc import Mapping

from graphnav import Metric, Source, Stage, Twist, hookimpl

FAMILY = "scored"


class Still(Source):
    \"\"\"Stands still.\"\"\"

    def step(self) -> Twist:
        return Twist(v_mps=0.0, omega_radps=0.0)


class Nothing(Stage):
    \"\"\"Scores what is not defined.\"\"\"

    metrics = (Metric("undefined", better="higher", help="Not defined."), Metric("one", better="lower", help="One."))

    def step(self, twist: Twist) -> None:
        pass

    def summary(self) -> Mapping[str, float]:
        return {"undefined": float("nan"), "one": 1.0}


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Still, Nothing]
"""


@pytest.fixture
def words(tmp_path: Path) -> list[str]:
    """Return the command line of a run of ten ticks, pictures and tap off."""
    (tmp_path / "scored.py").write_text(PLUGIN)
    graph = tmp_path / "graph.yaml"
    graph.write_text(
        "run: {until_s: 0.9}\nstages:\n  c: {use: scored.still}\n  s: {use: scored.nothing, in: {twist: c}}\n"
    )
    options = ["--plugin", str(tmp_path / "scored.py"), "--no-tap", "--no-pictures"]
    return ["run", str(graph), *options, "-o", str(tmp_path / "out")]


def no_constant(word: str) -> None:
    raise AssertionError(f"{word} is not JSON")


def test_json_is_the_summary_and_where_it_is(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words, "--json", "--seed", "5"]) == 0
    said = json.loads(capsys.readouterr().out, parse_constant=no_constant)
    assert said.pop("folder") == str(tmp_path / "out")
    assert said == json.loads((tmp_path / "out" / "summary.json").read_text(), parse_constant=no_constant)
    assert {"outcome", "seed", "frames", "wall_s", "stages", "scores", "versions"} <= said.keys()
    assert (said["outcome"], said["seed"], said["frames"]) == ("timeout", 5, 10)
    assert said["stages"]["s"].keys() == {"use", "steps", "p50_ms", "p99_ms", "dropped", "missed"}
    assert said["scores"] == {"s": {"undefined": None, "one": 1.0}}


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (["--seed", "-1"], "--seed: 'seed' is -1, but must be >= 0 and <= 4294967295\n"),
        (["--until", "0"], "--until: 'until_s' is 0, but must be > 0 and <= 1000000000\n"),
        (["--until", "nan"], "--until: 'until_s' must be a number or null, not nan\n"),
        (["--pace", "-1"], "--pace is -1, but must be above 0\n  remove it to run as fast as possible\n"),
        (["--pace", "inf"], "--pace is inf, but must be above 0\n  remove it to run as fast as possible\n"),
    ],
)
def test_an_option_out_of_bounds_is_refused_before_anything_runs(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str], option: list[str], said: str
) -> None:
    assert main([*words, *option]) == 2
    assert capsys.readouterr().err == said
    assert not (tmp_path / "out").exists()


DRAWING = """
from graphnav import Source, Stage, Twist, hookimpl

FAMILY = "drawn"


class Fails(Source):
    \"\"\"Fails at its second step.\"\"\"

    def reset(self, seed: int) -> None:
        self.steps = 0

    def step(self) -> Twist:
        self.steps += 1
        if self.steps == 2:
            raise ValueError("worn out")
        return Twist(v_mps=0.0, omega_radps=0.0)


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Fails]


@hookimpl
def graphnav_draw(recording, folder, video):
    raise {error}
"""


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        ("OSError(28, 'No space left on device')", 1, "cannot draw into {out}: No space left on device"),
        (
            "__import__('signal').raise_signal(2)",
            130,
            "some pictures were not drawn; to draw them, run: graphnav figure {out}",
        ),
    ],
)
def test_why_a_run_failed_is_said_even_if_it_cannot_be_drawn(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], error: str, status: int, said: str
) -> None:
    (tmp_path / "drawn.py").write_text(DRAWING.replace("{error}", error))
    graph, out = tmp_path / "graph.yaml", tmp_path / "out"
    graph.write_text("stages:\n  c: {use: drawn.fails}\n")
    assert main(["run", str(graph), "--plugin", str(tmp_path / "drawn.py"), "--no-tap", "-o", str(out)]) == status
    told = capsys.readouterr().err.splitlines()
    assert told[0] == "stage 'c' (drawn.fails) failed at 0.10 s: worn out"
    assert re.fullmatch(r"  \w+ at drawn\.py:\d+ in step", told[1])
    assert told[2] == "  -v shows the traceback"
    assert told[3] == said.format(out=out)


@pytest.mark.parametrize(("more", "has_traceback"), [([], False), (["-v"], True)])
def test_a_picture_that_cannot_be_drawn_costs_nothing_else(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str], has_traceback: bool
) -> None:
    (tmp_path / "drawn.py").write_text(PLUGIN + DRAWS_HALF)
    graph, out = tmp_path / "graph.yaml", tmp_path / "out"
    graph.write_text("run: {until_s: 0.9}\nstages:\n  c: {use: scored.still}\n")
    assert main(["run", str(graph), "--plugin", str(tmp_path / "drawn.py"), "--no-tap", "-o", str(out), *more]) == 0
    told = capsys.readouterr()
    raised = r"ValueError: zero size, in two lines \(ValueError at drawn\.py:\d+ in graphnav_draw\)\n"
    assert re.search(f"^not drawn: {raised}", told.err, re.MULTILINE)
    assert ("Traceback" in told.err, "-v shows the traceback" in told.err) == (has_traceback, not has_traceback)
    size = (out / "run.lcmlog").stat().st_size / 1e3
    assert told.out.endswith(f"{out}: run.lcmlog ({size:.0f} kB), graph.yaml, summary.json, first.png\n")


DRAWS_HALF = """

@hookimpl
def graphnav_draw(recording, folder, video):
    (folder / "first.png").write_bytes(b"drawn")
    raise ValueError("zero size,\\nin two lines")
"""
