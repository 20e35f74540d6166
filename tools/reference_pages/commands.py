"""The page of the commands, from the declarations of their parameters."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from graphnav.core.cli import command_called, commands
from reference_pages.markdown import bullets, code, page

_INTRO = """\
Every command prints this with `--help`. `graphnav --version` prints the version.

| exit status | meaning |
|---|---|
| 0 | done |
| 1 | the run failed, or every run of a study, or something differs that was compared |
| 2 | what was asked for is wrong: the message says where, what, and what to do |
| 130 | stopped by Ctrl-C, SIGTERM or SIGHUP |
| 141 | the program that reads the output has gone |

While a command starts, and after its last output, SIGTERM and SIGHUP end it as they end any program: a shell shows
128 plus their number. They do so in `spy`, `teleop` and `play`, too, where these hold a terminal. `record` ends with 0,
since a signal is how a recording ends; so does `spy` at Ctrl-C."""


def commands_page() -> str:
    """Return the page."""
    return page("Commands", _INTRO, *map(_section, commands()))


def _section(name: str) -> str:
    text, _ = commands()[name]
    parser = argparse.ArgumentParser(f"graphnav {name}")
    actions = [action for action in command_called(name).declare(parser) if action.help != argparse.SUPPRESS]
    words = [action for action in actions if not action.option_strings]
    options = [action for action in actions if action.option_strings]
    usage = " ".join(["graphnav", name, *(["[OPTIONS]"] if options else []), *map(_word, words)])
    parts = [f"## {name}", f"{text[0].upper()}{text[1:]}.", f"```\n{usage}\n```"]
    parts += [bullets(_line(action, parser) for action in (*words, *options)), *_epilog(parser)]
    return "\n\n".join(part for part in parts if part)


def _word(action: argparse.Action) -> str:
    name = _value(action)
    return {"?": f"[{name}]", "*": f"[{name} ...]", "+": f"{name} [{name} ...]"}.get(str(action.nargs), name)


def _value(action: argparse.Action) -> str:
    if action.choices is not None:
        return "{" + ",".join(map(str, action.choices)) + "}"
    if isinstance(action.metavar, tuple):
        return " ".join(action.metavar)
    return str(action.metavar or action.dest.upper())


def _line(action: argparse.Action, parser: argparse.ArgumentParser) -> str:
    value = "" if action.nargs == 0 else f" {_value(action)}"
    names = [f"{option}{value}" for option in action.option_strings] or [_value(action)]
    said = (action.help or "") % {**vars(action), "prog": parser.prog}
    return f"{', '.join(map(code, names))}: {said}" if said else ", ".join(map(code, names))


def _epilog(parser: argparse.ArgumentParser) -> Iterator[str]:
    if not parser.epilog:
        return
    if parser.formatter_class is argparse.RawDescriptionHelpFormatter:
        yield f"```text\n{parser.epilog.strip()}\n```"
    else:
        yield parser.epilog.strip()
