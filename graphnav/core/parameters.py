"""Declare a parameter once: parser, help, completion, reference page and Python functions read the declaration."""

from __future__ import annotations

import argparse
import inspect
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any, Literal, TypeVar

Candidates = Literal[
    "axes", "channels", "families", "feeds", "graphs", "hosts", "overrides", "run folders", "stages", "studies", "types"
]
"""Candidates that TAB may offer; without them it offers files."""
Completer = Callable[..., list[str]]
_ActionClass = type[argparse.Action]
F = TypeVar("F", bound=Callable[..., object])

MAX_S = 1e9
"""The longest time that an option takes: 30 years."""
_WIDTH = 120
_MAX_DIGITS = 12


@dataclass(frozen=True, eq=False)
class Parameter:
    """A parameter of commands, of Python functions, or of both.

    Where a command means something else by it, it says so by `but`; the rest stays as declared.
    """

    name: str
    """In Python, and of the parsed arguments of commands."""
    flags: str = ""
    """``"-n --number"``; empty for an argument by position, and where only Python functions have the parameter."""
    _: KW_ONLY
    help: str = ""
    """One line without a full stop; ``%(default)s`` is the default."""
    doc: str = ""
    """Said by Python functions instead of ``help``, in sentences: docstrings have room, and take other values."""
    type: Callable[[str], Any] | None = None
    """Converts a word of the command line; raises `argparse.ArgumentTypeError`."""
    default: Any = None
    choices: tuple[str, ...] | None = None
    metavar: str | tuple[str, ...] | None = None
    nargs: int | str | None = None
    const: Any = None
    required: bool | None = None
    action: str | _ActionClass | None = None
    """As of `argparse`; see also `flag` and `many`."""
    offers: Candidates | None = None
    example: str = ""
    """Python source for errors: ``write name=example``."""

    def but(self, **changes: Any) -> Parameter:
        """Return the parameter of a command that means something else by it."""
        return replace(self, **changes)

    @property
    def flag(self) -> str:
        """The last flag, which errors name."""
        return self.flags.split()[-1]

    @property
    def hint(self) -> str:
        """The suggestion of a Python function's error."""
        return f"write {self.name}={self.example}"

    @property
    def meaning(self) -> str:
        """The parameter in sentences, for docstrings."""
        return self.doc or f"{self.help[:1].upper()}{self.help[1:]}."

    def add_to(self, parser: argparse._ActionsContainer) -> argparse.Action:
        """Add it to a parser, or to a group of one."""
        names = ("type", "default", "choices", "metavar", "nargs", "const", "required", "action")
        given: dict[str, Any] = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        if self.flags:
            given["dest"] = self.name
        return parser.add_argument(*(self.flags.split() or [self.name]), help=self.help, **given)


def flag(name: str, flags: str, help: str, **more: Any) -> Parameter:  # noqa: A002 - as of Parameter
    """Declare an option without a value, False by default."""
    return Parameter(name, flags, help=help, action="store_true", default=False, **more)


def many(name: str, flags: str, **more: Any) -> Parameter:
    """Declare an option that may be given several times."""
    return Parameter(name, flags, action="append", default=[], **more)


def former(flags: str, now: str) -> Parameter:
    """Refuse an option of an earlier version, and suggest what it is called now."""

    class Refuse(argparse.Action):
        def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
            parser.error(f"unknown option {flags}: did you mean '{now}'?")

    return Parameter(flags.lstrip("-"), flags, action=Refuse, help=argparse.SUPPRESS)


class OneOf(tuple[Parameter, ...]):
    """Options of which only one may be given."""

    __slots__ = ()


@dataclass(frozen=True)
class Command:
    """A command: its function, and its parameters in the order of ``--help``."""

    run: Callable[[Any], int]
    parameters: tuple[Parameter | OneOf, ...]
    epilog: str | None
    is_verbatim: bool

    def __call__(self, args: argparse.Namespace) -> int:
        """Run the command; return its exit status."""
        return self.run(args)

    def declare(
        self, parser: argparse.ArgumentParser, completer: Callable[[Candidates], Completer] | None = None
    ) -> list[argparse.Action]:
        """Add the parameters and what stands below them to a parser; ``completer`` makes what TAB asks."""
        parser.epilog = self.epilog
        if self.is_verbatim:
            parser.formatter_class = argparse.RawDescriptionHelpFormatter
        actions = []
        for parameter, group in self._grouped(parser):
            action = parameter.add_to(group)
            if completer is not None and parameter.offers is not None:
                action.completer = completer(parameter.offers)  # type: ignore[attr-defined]
            actions.append(action)
        return actions

    def _grouped(self, parser: argparse.ArgumentParser) -> Iterator[tuple[Parameter, argparse._ActionsContainer]]:
        for declared in self.parameters:
            if isinstance(declared, OneOf):
                group = parser.add_mutually_exclusive_group()
                yield from ((parameter, group) for parameter in declared)
            else:
                yield declared, parser


def command(
    *parameters: Parameter | OneOf, about: str | None = None, examples: str | None = None
) -> Callable[[Callable[[Any], int]], Command]:
    """Make a function a command: it gets the parsed arguments by the names of its parameters, returns its exit status.

    Its help ends with ``about``, a paragraph, or with ``examples``, printed as they stand.
    """
    return lambda run: Command(run, parameters, examples or about, examples is not None)


def documented(*parameters: Parameter) -> Callable[[F], F]:
    """Put what the parameters mean into a Python function's docstring, in front of what it raises."""
    meanings = {parameter.name: parameter.meaning for parameter in parameters}

    def document(function: F) -> F:
        if function.__doc__ is None:  # python -OO
            return function
        text, raises, errors = inspect.cleandoc(function.__doc__).partition("Raises\n------")
        entries = [f"{name}\n{_indented(meanings[name])}" for name in inspect.signature(function).parameters]
        section = "\n".join(["Parameters", "----------", *entries])
        function.__doc__ = f"{text.rstrip()}\n\n{section}\n\n{raises}{errors}".rstrip()
        return function

    return document


@dataclass(frozen=True)
class Integer:
    """An integer within bounds, on the command line (``type``) and in Python."""

    minimum: int
    maximum: int = 10**_MAX_DIGITS - 1
    noun: str = ""
    """The name of a number of these bounds: a seed."""

    def __call__(self, text: str) -> int:
        """Convert a word of the command line."""
        if text.isascii() and text.isdecimal() and len(text) <= _MAX_DIGITS:
            value = int(text)
            if self.minimum <= value <= self.maximum:
                return value
        bounds = "above 0" if self.minimum == 1 else f"of at least {self.minimum}"
        wanted = f"an integer {bounds}, of at most {_MAX_DIGITS} digits"
        if self.noun:
            wanted = f"{self.noun}: write an integer from {self.minimum} to {self.maximum}"
        raise argparse.ArgumentTypeError(f"'{text}' is not {wanted}")


def seconds(text: str) -> float:
    """Parse a duration above 0."""
    try:
        if 0 < (value := float(text)) <= MAX_S:
            return value
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not a number of seconds above 0, at most {MAX_S:g}")


COUNT = Integer(1)
SEED_NUMBER = Integer(0, 2**32 - 1, "a seed")


def _indented(text: str) -> str:
    return textwrap.fill(text, _WIDTH, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False)
