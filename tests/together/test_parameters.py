"""Parameters are declared once: the parser, the help, TAB, docstrings and checks of Python functions agree."""

from __future__ import annotations

import argparse
import inspect
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import get_args

import pytest

import graphnav
from graphnav.core.api.arguments import Argument
from graphnav.core.api.parameters import Shared
from graphnav.core.cli import command_called, commands
from graphnav.core.errors import UserError
from graphnav.core.parameters import Integer, OneOf, Parameter, command, documented, flag, former, many
from graphnav.core.spec import RecordOption
from graphnav.develop.parameters import CLOCK, FUNCTIONS
from graphnav.studies.parameters import OF_FUNCTIONS

SHARED = {parameter.name: parameter for parameter in (*Shared.OF_RUN, CLOCK, FUNCTIONS)}
OF_STUDIES = SHARED | {parameter.name: parameter for parameter in OF_FUNCTIONS}
FUNCTIONS_OF: dict[Callable[..., object], dict[str, Parameter]] = {
    **dict.fromkeys((graphnav.run, graphnav.load, graphnav.check, graphnav.draw, graphnav.profile), SHARED),
    **dict.fromkeys((graphnav.ablate, graphnav.tune), OF_STUDIES),
}

SPEED = Parameter("speed_mps", "-s --speed", type=float, default=0.5, metavar="V", help="speed (default: %(default)s)")
N_LAPS = Parameter("laps", "--laps", type=Integer(1), metavar="N", help="laps to drive", example="3")
MODE = Parameter("mode", "--mode", choices=("slow", "fast"), default="slow", help="how", example='"slow" indoors')
GOALS = many("goals", "--goal", metavar="GOAL", help="a goal", example='"door"', offers="channels")
ROOM = Parameter("room", metavar="ROOM", type=Path, help="the room", example='"kitchen"')


@command(
    ROOM,
    SPEED,
    N_LAPS.but(help="laps"),
    MODE,
    GOALS,
    OneOf((flag("json", "--json", "as JSON"), flag("csv", "--csv", "as csv"))),
    former("--velocity", "--speed"),
    about="It drives.",
)
def drive(args: argparse.Namespace) -> int:
    """Drive."""
    return len(args.goals)


def parser() -> argparse.ArgumentParser:
    made = argparse.ArgumentParser("drive")
    drive.declare(made)
    return made


def test_a_command_is_one_function() -> None:
    args = parser().parse_args(["hall", "-s", "2", "--goal", "a", "--goal", "b"])
    assert (args.room, args.speed_mps, args.laps, args.mode, args.json) == (Path("hall"), 2.0, None, "slow", False)
    assert drive(args) == 2
    assert parser().parse_args(["hall"]).goals == []


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["hall", "--laps", "0"], "argument --laps: '0' is not an integer above 0, of at most 12 digits"),
        (["hall", "--mode", "mad"], "argument --mode: invalid choice: 'mad'"),
        (["hall", "--json", "--csv"], "argument --csv: not allowed with argument --json"),
        (["hall", "--velocity", "3"], "unknown option --velocity: did you mean '--speed'?"),
        ([], "the following arguments are required: ROOM"),
    ],
)
def test_the_command_line_is_checked(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        parser().parse_args(words)
    assert message in capsys.readouterr().err


def test_help_says_what_is_declared() -> None:
    text = parser().format_help()
    assert "speed (default: 0.5)" in text
    assert text.endswith("It drives.\n")
    assert "--velocity" not in text
    assert N_LAPS.help == "laps to drive", "what one command says by `but` is that command's"


@pytest.mark.parametrize(
    ("check", "message"),
    [
        (
            lambda: Argument(0, N_LAPS).check_integer(),
            "laps must be an integer of at least 1, not 0 (int)\n  write laps=3",
        ),
        (
            lambda: Argument(10**12, N_LAPS).check_integer(),
            "laps must be at most 999999999999, not 1000000000000 (int)",
        ),
        (
            lambda: Argument("mad", MODE).check_choice(),
            'mode must be "slow" or "fast", not \'mad\' (str)\n  write mode="slow" in',
        ),
        (Argument("a", GOALS).texts, "goals must be a list, not 'a' (str)\n  write goals=[\"door\"]"),
        (Argument([1], GOALS).texts, 'goals[0] must be a string, not 1 (int)\n  write goals=["door"]'),
        (Argument(3, ROOM).path, 'room must be a path, not 3 (int)\n  write room="kitchen"'),
    ],
)
def test_python_values_are_checked(check: Callable[[], object], message: str) -> None:
    with pytest.raises(UserError) as error:
        check()
    assert str(error.value).startswith(message)


def test_a_docstring_says_what_the_help_says() -> None:
    @documented(SPEED.but(doc="In m/s."), N_LAPS)
    def circle(*, speed_mps: float = 0.5, laps: int | None = None) -> None:
        """Drive in circles.

        Raises
        ------
        UserError
            Too fast.
        """

    expected = "Drive in circles.\n\nParameters\n----------\nspeed_mps\n    In m/s.\nlaps\n    Laps to drive.\n\nRaises"
    assert (circle.__doc__ or "").startswith(expected)


@pytest.mark.parametrize("function", FUNCTIONS_OF, ids=lambda function: function.__name__)
def test_a_function_has_the_declared_defaults(function: Callable[..., object]) -> None:
    declared = FUNCTIONS_OF[function]
    for name, argument in inspect.signature(function).parameters.items():
        if argument.default is not inspect.Parameter.empty:
            assert (argument.default or None) == (declared[name].default or None), name


def test_a_record_option_of_a_graph_is_one_of_the_command_line() -> None:
    assert set(Shared.RECORD.choices or ()) == set(get_args(RecordOption))


def every_parameter(name: str) -> Iterator[Parameter]:
    for declared in command_called(name).parameters:
        yield from declared if isinstance(declared, OneOf) else (declared,)


@pytest.mark.parametrize("name", commands())
def test_a_parameter_of_a_command_has_one_name_everywhere(name: str) -> None:
    shared = {parameter.flag: parameter for parameter in OF_STUDIES.values() if parameter.flags.startswith("--")}
    for parameter in every_parameter(name):
        if parameter.flags and parameter.flag in shared and parameter.type == shared[parameter.flag].type:
            assert parameter.name == shared[parameter.flag].name
        assert parameter.help


def test_nothing_but_a_declaration_adds_to_a_parser() -> None:
    package = Path(graphnav.__file__).parent
    found = [path for path in package.rglob("*.py") if ".add_argument(" in path.read_text(encoding="utf-8")]
    assert sorted(path.relative_to(package).as_posix() for path in found) == [
        "core/cli/command_line.py",
        "core/parameters.py",
    ]
