"""Errors in one shape: where, what, and what to do.

Every start of the command line loads this module, so that it loads little: no dataclasses, pathlib or difflib.
"""

from __future__ import annotations

import os
import re
import sys
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import MappingProxyType, TracebackType
from typing import TYPE_CHECKING, Literal, NamedTuple

from graphnav.core.interrupts import CtrlC

if TYPE_CHECKING:
    from pathlib import Path

_MAX_LINE = 1000
"""The longest line that is made of what a plugin raised or returned, characters."""

_NO_PLUGINS = {"", "graphnav", "pluggy", *sys.stdlib_module_names}
"""Top-level packages through which a plugin is called."""

_EMOJI = "\u2190-\u2bff\ufe0e\ufe0f\U0001f000-\U0001faff"
_EMOJI_JOINER = re.compile(f"(?<=[{_EMOJI}])\u200d(?=[{_EMOJI}])")
_INVISIBLE = re.compile("[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u3164\ufe00-\ufe0d\uffa0\U000e0000-\U000e0fff]")
"""Characters without a glyph that `str.isprintable` lets through: fillers and selectors, but not those of emoji."""

ProblemKind = Literal["wrong", "unknown", "ambiguous", "duplicate", "untrusted"]
"""A name that is not known, several candidates for one wire, something given twice, code that is not trusted and so did
not run; ``wrong``: anything else."""


class Place(NamedTuple):
    """Location of something in a file, or an option of the command line as it was typed.

    ``line`` and ``column`` count from 1, 0 if unknown. Without a line the column says which value of an option it is,
    and is not printed.
    """

    file: str
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        file = shown_name(self.file)
        if not self.line:
            return file
        return f"{file}:{self.line}:{self.column}" if self.column else f"{file}:{self.line}"


class Suggestion(NamedTuple):
    """Words to write instead; false if there are none."""

    names: tuple[str, ...]
    """The words alone, the nearest first."""
    text: str
    """The sentence that proposes them."""

    def __bool__(self) -> bool:
        return bool(self.names)

    def __str__(self) -> str:
        return self.text


Hint = str | Suggestion


class Problem:
    """One thing that is wrong: where, what, and an imperative that fixes it (empty if there is none).

    ``raised``: the exception of a plugin, if that is the problem: its traceback can be shown. It is not compared.
    """

    place: Place | None
    what: str
    hint: Hint
    kind: ProblemKind
    raised: BaseException | None

    __slots__ = ("hint", "kind", "place", "raised", "what")

    def __init__(
        self,
        place: Place | None,
        what: str,
        hint: Hint = "",
        kind: ProblemKind = "wrong",
        raised: BaseException | None = None,
    ) -> None:
        near = isinstance(hint, Suggestion) and bool(hint)
        # a near name is proposed where one is not known
        told = (hint, "unknown" if kind == "wrong" and near else kind, place, raised, what)
        for name, value in zip(self.__slots__, told, strict=True):
            object.__setattr__(self, name, value)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a problem cannot be changed: '{name}'")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Problem) and self._compared == other._compared

    def __hash__(self) -> int:
        return hash(self._compared)

    def __repr__(self) -> str:
        return f"Problem{self._compared}"

    @property
    def _compared(self) -> tuple[Place | None, str, Hint, ProblemKind]:
        return self.place, self.what, self.hint, self.kind

    @property
    def suggestion(self) -> str:
        """The word to write instead of an unknown one; empty if none is near."""
        return self.hint.names[0] if isinstance(self.hint, Suggestion) and self.hint else ""

    def __str__(self) -> str:
        where = f"{self.place}: " if self.place else ""
        return f"{where}{self.what}" + "".join(f"\n  {line}" for line in str(self.hint).splitlines())


class GraphnavError(Exception):
    """Base of every error that graphnav raises on purpose; its string can be printed, whatever a message quotes."""

    def __str__(self) -> str:
        return printable(super().__str__())

    @property
    def cause(self) -> str:
        """Message without the time of the error: the same for errors of one kind."""
        return str(self)


class UserError(GraphnavError):
    """Something that a user wrote or asked for is wrong; exit status 2.

    Carries all problems found, sorted by place.
    """

    def __init__(self, problems: Problem | Iterable[Problem]) -> None:
        found = [problems] if isinstance(problems, Problem) else list(problems)
        self.problems = sorted(found, key=lambda problem: problem.place or Place(""))
        super().__init__("\n".join(map(str, self.problems)))

    @classmethod
    def of(cls, what: str, hint: Hint = "", place: Place | None = None) -> UserError:
        """Return an error with a single problem."""
        return cls(Problem(place, what, hint))


class ParamError(GraphnavError):
    """A stage's parameter cannot be used; shown at the parameter's place in the graph.

    Raised by ``Stage.check`` and by a stage's construction.
    """

    def __init__(self, param: str, what: str, hint: Hint = "") -> None:
        self.param, self.what, self.hint = param, what, hint
        super().__init__(f"{param}: {what}" + (f"\n  {hint}" if hint else ""))


class DeclarationError(GraphnavError):
    """A stage or message class is declared in a way that graphnav cannot read."""


class CatalogError(UserError):
    """A stage is not in the catalog, or its plugin cannot be used; shown at the ``use`` that asked for it."""

    def __init__(self, what: str, hint: Hint = "", raised: BaseException | None = None) -> None:
        self.what, self.hint, self.raised = what, hint, raised
        super().__init__(Problem(None, what, hint, raised=raised))

    def problem(self, place: Place | None, before: str = "") -> Problem:
        """Return it as a problem at the place of the ``use`` that asked for it; ``before`` precedes what it says."""
        return Problem(place, before + self.what, self.hint, raised=self.raised)


class StageError(GraphnavError):
    """A stage raised, or returned what it may not; the run stops, its log is complete; exit status 1."""

    def __init__(self, stage: str, use: str, at_s: float, what: str, raised_at: str = "") -> None:
        self.stage, self.use, self.at_s, self.what, self.raised_at = stage, use, at_s, what, raised_at
        super().__init__(str(Problem(None, f"stage '{stage}' ({use}) failed at {at_s:.2f} s: {what}", raised_at)))

    @property
    def cause(self) -> str:
        """Message without the time of the error."""
        return f"stage '{self.stage}' ({self.use}) failed: {self.what}"


class BusError(GraphnavError):
    """LCM could not be opened or used: what happened, and what to do (empty if nothing can be)."""

    def __init__(self, what: str, hint: str = "") -> None:
        self.what, self.hint = what, hint
        super().__init__(str(Problem(None, what, hint)))


class NoRouteError(BusError):
    """No multicast route leads to a group."""


class LogError(GraphnavError):
    """A log could not be written or read."""


class BagError(UserError, LogError):
    """A ROS 2 bag cannot be read: what was found where, and what to do; exit status 2."""


class DrawingError(GraphnavError):
    """A plugin that draws raised; what it drew from is unchanged. One line."""


def did_you_mean(word: str, known: Iterable[str], renamed: Mapping[str, str] = MappingProxyType({})) -> Suggestion:
    """Return the hint for an unknown word: its new name if it was ``renamed``, else the nearest of ``known``.

    It is false if there is neither.
    """
    if word in renamed:
        return Suggestion((renamed[word],), f"did you mean '{renamed[word]}'? It was renamed")
    import difflib  # noqa: PLC0415 - see the module

    near = difflib.get_close_matches(word, sorted(known), n=1, cutoff=0.6)
    return Suggestion(tuple(near), f"did you mean '{near[0]}'?") if near else Suggestion((), "")


def one_line(error: BaseException) -> str:
    """Return an exception's type and message in one line, even if its ``__str__`` raises."""
    message, name = message_line(error), shown_name(type(error).__name__)
    return f"{name}: {message}" if message else name


def message_line(error: BaseException) -> str:
    """Return an exception's message in one line of bounded length, even if its ``__str__`` raises."""
    return _bounded(" ".join(_converted(str, error).split()))


def failure_line(error: BaseException) -> str:
    """Return what a plugin raised in one line: the message alone where the type adds nothing to it."""
    is_telling = isinstance(error, ValueError | RuntimeError)
    return (message_line(error) if is_telling else "") or one_line(error)


def raised_line(error: BaseException, modules: Iterable[str] = ()) -> str:
    """Return where a plugin raised, as ``ZeroDivisionError at my_stage.py:17 in step``; empty if not within its files.

    The location is that of the innermost call into a file of the plugin, not into numpy's that it uses. ``modules``:
    those that are the plugin's, besides the package whose code was called.
    """
    frames = [(tb.tb_frame, tb.tb_lineno) for tb in _tracebacks(error)]
    names = [str(frame.f_globals.get("__name__", "")) for frame, _ in frames]
    packages = [name.partition(".")[0] for name in names]
    called = next((package for package in packages if package not in _NO_PLUGINS), None)
    own = {called, *(module.partition(".")[0] for module in modules)} - _NO_PLUGINS
    found = [k for k, package in enumerate(packages) if package in own]
    if not found:
        return ""
    (frame, line), name = frames[found[-1]], names[found[-1]]
    parts = frame.f_code.co_filename.split(os.sep)
    depth = name.count(".") + (2 if parts[-1] == "__init__.py" else 1)
    file, function = "/".join(parts[-depth:]), frame.f_code.co_name
    where = "" if function == "<module>" else f" in {function}"
    return _bounded(shown_name(f"{type(error).__name__} at {file}:{line}{where}"))


def fix_the_plugin(error: BaseException, modules: Iterable[str] = ()) -> str:
    """Return the hint for what a plugin raised before a run: its location, as `raised_line` gives it."""
    raised = raised_line(error, modules)
    return f"fix the plugin: {raised}" if raised else "fix the plugin"


def _tracebacks(error: BaseException) -> Iterator[TracebackType]:
    found = error.__traceback__
    while found is not None:
        yield found
        found = found.tb_next


def shown_value(value: object) -> str:
    """Return the ``repr`` of a plugin's value in one line of bounded length, even if it raises."""
    return _bounded(" ".join(_converted(repr, value).split()))


def _converted(convert: Callable[[object], str], value: object) -> str:
    """Return ``convert(value)``, which may be a plugin's code; a remark if it raises."""
    try:
        return convert(value)
    except CtrlC:
        raise
    except BaseException as error:  # noqa: BLE001 - a plugin's code
        return f"(its __{convert.__name__}__ raises {type(error).__name__})"


def _bounded(line: str) -> str:
    return line if len(line) <= _MAX_LINE else f"{line[:_MAX_LINE]} (and {len(line) - _MAX_LINE:,} more characters)"


def printable(text: str) -> str:
    r"""Return a string in which nothing acts on a terminal, changes the order of the text, or is invisible.

    Control characters, directional overrides and characters without width become escapes such as ``\x1b`` and
    ``\u202e``. Line breaks, tabs, spaces of all widths and the joiners inside emoji stay.
    """
    if text.isascii() and text.isprintable():
        return text
    return "\u200d".join("".join(map(_shown, part)) for part in _EMOJI_JOINER.split(text))


def _shown(char: str) -> str:
    """Return a character, or its escape."""
    is_shown = char.isprintable() or char in "\n\t" or unicodedata.category(char) == "Zs"
    return char if is_shown and not _INVISIBLE.match(char) else _escape(char)


def _escape(char: str) -> str:
    return char.encode("unicode_escape").decode()


def shown_path(path: Path) -> str:
    """Return a path as errors name it: from the working folder where it lies below."""
    try:
        return shown_name(str(path.resolve().relative_to(os.getcwd())))
    except ValueError:
        return shown_name(str(path))


def shown_name(name: str) -> str:
    """Return a name from a log or the network as a terminal may print it: nothing in it that it would obey."""
    return "".join(char if char.isprintable() else _escape(char) for char in printable(name))
