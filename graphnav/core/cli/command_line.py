"""The command line: ``graphnav COMMAND``."""

from __future__ import annotations

import argparse
import importlib
import io
import os
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from itertools import takewhile
from typing import TYPE_CHECKING, Any

from graphnav.core.cli.command_arguments import CommandArguments
from graphnav.core.cli.lasting_output import ReaderLeftError, lasting_output
from graphnav.core.cli.status import Exit
from graphnav.core.interrupts import CtrlC, ctrl_c_not_lost, end_at_interrupt, raise_at_interrupt
from graphnav.core.machine.escaped_streams import escaped_output
from graphnav.core.machine.pins import unpin
from graphnav.core.machine.system import require_linux
from graphnav.core.machine.threads import ONE_THREAD
from graphnav.core.rooms import in_room, linux_commands, rooms

if TYPE_CHECKING:
    from graphnav.core.errors import UserError
    from graphnav.core.parameters import Candidates, Command, Completer

COMMANDS = {
    "run": "run a graph into a run folder: log, summary, pictures",
    "check": "report all errors of graphs, with line and column",
    "draw": "draw a graph: boxes in the terminal, svg, mermaid or dot",
    "stages": "list the installed stages, describe one, or list what writes and reads a message",
    "trust": "list, trust or revoke the folders whose plugin files may run when their graphs are read",
}
"""The core's commands and their help; ``main`` of the module ``graphnav.core.cli.<command>`` is the `Command`."""

_ORDER = (
    "run",
    "up",
    "ps",
    "logs",
    "stop",
    "ablate",
    "tune",
    "check",
    "draw",
    "stages",
    "new-stage",
    "schema",
    "teach",
    "profile",
    "replay",
    "figure",
    "export",
    "record",
    "play",
    "info",
    "spy",
    "echo",
    "hz",
    "bw",
    "top",
    "view",
    "pub",
    "teleop",
    "types",
    "lcm-spy",
    "doctor",
    "trust",
    "completion",
)
"""The commands in the order of ``--help``; others follow."""

FOR_A_READER = {"spy", "echo", "hz", "bw", "top", "info"}
"""Commands that exit on a broken pipe; all others finish their work."""
_EMPTIED = re.compile("(--[^=]+)=--|(-[A-Za-z])--")
"""Options with two dashes for a value."""


class _Parser(argparse.ArgumentParser):
    """Takes options by their full names only, and says what is near to an unknown one.

    Raises the error that keeps its help from being printed, such as that of a full disk.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **{"allow_abbrev": False} | kwargs)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Refuse an unknown option before the command; what follows the command is its own parser's."""
        words = list(sys.argv[1:] if args is None else args)
        self._refuse_unknown(takewhile(lambda word: word.startswith("-"), words))
        return super().parse_known_args(args, namespace)

    def _refuse_unknown(self, words: Iterable[str]) -> None:
        """Exit with the error of the first unknown ``--option``, which names the nearest."""
        from graphnav.core.errors import did_you_mean

        for word in words:
            name = word.partition("=")[0]
            if name.startswith("--") and name != "--" and " " not in name and name not in self._option_string_actions:
                known = [option[2:] for option in self._option_string_actions if option.startswith("--")]
                begun = [option for option in known if option.startswith(name[2:])]
                near = begun if len(begun) == 1 else did_you_mean(name[2:], known).names
                hint = f"did you mean '--{near[0]}'?" if near else f"see {self.prog} --help"
                self.error(f"unknown option {name}: {hint}")

    def _print_message(self, message: str, file: Any = None) -> None:
        if message and file is not None and file is sys.stdout:
            file.write(message)
        else:
            super()._print_message(message, file)


class _Intermixed(_Parser):
    """Accepts options between positional arguments: before Python 3.12 ``echo CHANNEL -n 1 LOG`` loses LOG.

    Refuses ``--option=--``, of which older versions of Python make an empty list.
    """

    _is_within = False

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse options first, then positional arguments."""
        if self._is_within:
            return argparse.ArgumentParser.parse_known_args(self, args, namespace)
        words = list(sys.argv[1:] if args is None else args)
        options = words[: words.index("--") if "--" in words else None]
        self._refuse_unknown(options)
        for word in options:
            if found := _EMPTIED.fullmatch(word):
                self.error(f"argument {found[1] or found[2]}: '--' is not a value")
        self._is_within = True
        try:
            return self.parse_known_intermixed_args(args, namespace)
        finally:
            self._is_within = False


def build_parser(
    chosen: str | None,
    command_class: type[argparse.ArgumentParser] = _Intermixed,
    completer: Callable[[Candidates], Completer] | None = None,
) -> argparse.ArgumentParser:
    """Return the parser; only the ``chosen`` command's module is imported and its parameters added."""
    from graphnav import __version__

    parser = _Parser(
        prog="graphnav", description="Visual navigation as a dataflow graph of plugin stages on LCM channels."
    )
    parser.add_argument("--version", action="version", version=f"graphnav {__version__}")
    subparsers = parser.add_subparsers(title="commands", metavar="COMMAND", dest="command", parser_class=command_class)
    for name, (text, _) in commands().items():
        sub = subparsers.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        if name == chosen:
            run = command_called(name)
            run.declare(sub, completer)
            sub.set_defaults(main=run)
    return parser


def command_called(name: str) -> Command:
    """Return an installed command, from the module of its name."""
    _, package = commands()[name]
    found: Command = importlib.import_module(f"{package}.{name.replace('-', '_')}").main
    return found


def commands() -> dict[str, tuple[str, str]]:
    """Return every installed command with its help and the package of its module, as ``--help`` lists them."""
    found = {name: (text, "graphnav.core.cli") for name, text in COMMANDS.items()}
    for room in rooms():
        found.update({name: (text, f"{room.__name__}.commands") for name, text in room.COMMANDS.items()})
    return {name: found[name] for name in (*_ORDER, *found) if name in found}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Return the exit status: 0 ok, 1 failed, 2 usage error, 130 ended by Ctrl-C, SIGTERM or SIGHUP, 141 broken pipe.
    """
    _show_what_the_terminal_can()
    for variable, value in ONE_THREAD.items():
        os.environ.setdefault(variable, value)
    if argv is None and "_ARGCOMPLETE" in os.environ:
        _complete()
    words = list(sys.argv[1:] if argv is None else argv)
    chosen = next((word for word in words if not word.startswith("-")), None)
    with lasting_output(for_a_reader=chosen in FOR_A_READER), escaped_output(), ctrl_c_not_lost():
        return _status_of(words, chosen, owns_process=argv is None)


def _status_of(words: list[str], chosen: str | None, *, owns_process: bool) -> int:
    """Run a command; print the error that ends it."""
    from graphnav.core.errors import GraphnavError, ParamError, UserError

    args, n_raised = CommandArguments(), CtrlC.n_raised
    try:
        args = _parsed(words, chosen)
        args.words, args.owns_process = words, owns_process
        if owns_process:
            raise_at_interrupt()
        try:
            _choose_instruction_set(getattr(args, "portable", None))
            _require_working_folder()
            status = int(args.main(args))
            if sys.stdout is not None:
                sys.stdout.flush()
        finally:
            if owns_process:
                end_at_interrupt()
    except UserError as error:
        _print_problems(error, args)
        return Exit.USER_ERROR
    except ParamError as error:
        print(error, file=sys.stderr)
        return Exit.USER_ERROR
    except GraphnavError as error:
        print(error, file=sys.stderr)
        return Exit.FAILED
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        return Exit.INTERRUPTED
    except ReaderLeftError:
        return Exit.PIPE_CLOSED
    except OSError as error:
        where = f": {error.filename}" if error.filename else ""
        print(f"stopped: {error.strerror or error}{where}", file=sys.stderr)
        return Exit.FAILED
    except Exception as error:
        if n_raised == CtrlC.n_raised and not _is_after_ctrl_c(error):
            raise
        print("stopped", file=sys.stderr)
        return Exit.INTERRUPTED
    return status


def _parsed(words: list[str], chosen: str | None) -> CommandArguments:
    """Return the arguments; print the help where no command is given, exit with the error of a wrong one."""
    from graphnav.core.errors import did_you_mean, shown_name

    known = commands()
    if chosen in linux_commands():
        require_linux(f"'graphnav {chosen}' works")
    parser = build_parser(chosen if chosen in known else None)
    if chosen is not None and chosen not in known:
        hint = did_you_mean(chosen, known) or "see graphnav --help"
        parser.error(f"unknown command '{shown_name(chosen)}': {hint}")

    def print_help(_: argparse.Namespace) -> int:
        parser.print_help()
        return Exit.OK

    parser.set_defaults(main=print_help)
    return parser.parse_args(words, CommandArguments())


def _print_problems(error: UserError, args: CommandArguments) -> None:
    """Print what is wrong; what a plugin raised with its traceback if ``-v`` asks for it."""
    from graphnav.core.cli.options import FailureReport

    print(error, file=sys.stderr)
    if len(error.problems) > 1:
        print(f"{len(error.problems)} errors", file=sys.stderr)
    raised = [problem.raised for problem in error.problems if problem.raised is not None]
    if raised and hasattr(args, "verbose"):
        report = FailureReport(args)
        for each in raised:
            report(each)
        report.print()


def _is_after_ctrl_c(error: BaseException | None) -> bool:
    """Whether an error came while Ctrl-C was ending the command, as at a second one in the code of a library."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__context__
    return error is not None


def _require_working_folder() -> None:
    """Raise UserError if the working folder was removed: paths mean nothing then."""
    from graphnav.core.errors import UserError

    try:
        os.getcwd()
    except OSError as error:
        raise UserError.of(
            "the working folder does not exist any more", "change to one that does, such as: cd ~"
        ) from error


def _choose_instruction_set(portable: bool | None) -> None:  # noqa: FBT001 - an option's value
    """Obey ``--portable`` and ``--no-portable``, before numpy and OpenCV are loaded."""
    if portable is False:
        unpin()
    elif portable:
        from graphnav.core.machine.instruction_set import require_portable

        require_portable()


def _complete() -> None:
    """Answer the shell that asks what can follow; does not return."""
    completion = in_room("develop.completion")
    chosen = completion.completed_command()
    completion.complete(build_parser(chosen, argparse.ArgumentParser, completion.completer))


def _show_what_the_terminal_can() -> None:
    """Replace characters that the terminal's encoding lacks with a question mark, instead of failing.

    A width of 0, which some terminals declare, is none: nothing would be shown.
    """
    if os.environ.get("COLUMNS", "").strip("0") == "":
        os.environ.pop("COLUMNS", None)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
