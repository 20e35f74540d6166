"""Answer a shell that asks for completions; the script that makes it ask."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from graphnav import GraphnavError
from graphnav.core.parameters import Candidates, Completer
from graphnav.core.run_folder import RunFolder
from graphnav.develop.completion.index import Index, installed_index

_YAML = (".yaml", ".yml")
_Finder = Callable[[str, list[str], Index], Iterable[str]]
"""Of a prefix, the graphs and studies of the command line, and the index."""
_TIMES = ("every_ms", "deadline_ms")
_RUNS = "runs"
_MAX_RUNS = 20
SHELLS = ("bash", "zsh", "fish")


def _graphs(prefix: str, _: list[str], index: Index) -> Iterable[str]:
    return [*index.graphs, *paths(prefix, _YAML)]


def _studies(prefix: str, _: list[str], index: Index) -> Iterable[str]:
    return [*index.studies, *index.graphs, *paths(prefix, _YAML)]


def _stages(_: str, __: list[str], index: Index) -> Iterable[str]:
    return [*index.families, *index.params]


def _channels(prefix: str, _: list[str], index: Index) -> Iterable[str]:
    done = prefix.rpartition(",")[0] + "," if "," in prefix else ""
    return [f"{done}{channel}" for channel in index.channels]


def stages_of(names: Iterable[str], index: Index) -> dict[str, str]:
    """Return the class of each stage of some graphs and studies; of a file what it and the graphs it extends say.

    No plugin is imported: TAB runs nothing that a graph names.
    """
    uses: dict[str, str] = {}
    for name in names:
        if name in index.studies:
            uses |= stages_of(index.studies[name], index)
        elif name in index.graphs:
            uses |= index.graphs[name]
        else:
            from graphnav.core.graph import find_graph, outline_of_file

            with suppress(GraphnavError):
                uses |= {stage.name: stage.use for stage in outline_of_file(find_graph(name)).stages.values()}
    return uses


def _overrides(prefix: str, names: list[str], index: Index) -> Iterable[str]:
    return override_candidates(prefix, stages_of(names, index), index)


def _axes(prefix: str, names: list[str], index: Index) -> Iterable[str]:
    return override_candidates(prefix, stages_of(names, index), index, many=True)


_BY_KIND: Mapping[Candidates, _Finder] = {
    "axes": _axes,
    "channels": _channels,
    "families": lambda _, __, index: index.families,
    "feeds": lambda prefix, _, __: [*other_computers(), *run_folders(prefix)],
    "graphs": _graphs,
    "hosts": lambda _, __, ___: other_computers(),
    "overrides": _overrides,
    "run folders": lambda prefix, _, __: run_folders(prefix),
    "stages": _stages,
    "studies": _studies,
    "types": lambda _, __, index: index.types,
}
"""Candidates by the kind that a parameter offers."""


def completed_command() -> str | None:
    """Return the command on the line that the shell asks about, None where it asks for the command itself."""
    words = _words()
    return next((word for word in words if not word.startswith("-")), None)


def complete(parser: argparse.ArgumentParser) -> None:
    """Print the completions of the line in the environment, and end the process."""
    import argcomplete

    argcomplete.autocomplete(parser, always_complete_options=False)


def completer(kind: Candidates) -> Completer:
    """Return the function that argcomplete asks for the values of a parameter."""

    def completions(prefix: str, parsed_args: argparse.Namespace, **_: Any) -> list[str]:
        given = getattr(parsed_args, "graph", None) or getattr(parsed_args, "study", None) or []
        names = [given] if isinstance(given, str) else list(given)
        return [text for text in _BY_KIND[kind](prefix, names, installed_index()) if text.startswith(prefix)]

    return completions


def _words() -> list[str]:
    """Return the complete words behind the program."""
    import argcomplete.lexers

    line, point = os.environ.get("COMP_LINE", ""), int(os.environ.get("COMP_POINT", "0"))
    before: list[str] = argcomplete.lexers.split_line(line, point)[3]
    return before[1:]


def override_candidates(text: str, uses: Mapping[str, str], index: Index, *, many: bool = False) -> Iterator[str]:
    """Yield completions of an override of a graph whose stages are of the classes ``uses``.

    ``many``: values are separated by commas, as in ``--vary``; the last one is completed.
    """
    target, equals, value = text.partition("=")
    if equals:
        done = value.rpartition(",")[0] + "," if many and "," in value else ""
        yield from (f"{target}={done}{one}" for one in _values(target.rstrip("+"), uses, index))
        return
    stage, dot, _ = text.partition(".")
    if not dot:
        yield from (f"{name}{sign}" for name in uses for sign in "=.")
        yield "run."
    elif stage == "run":
        yield from (f"run.{name}=" for name in index.run_options)
    elif stage in uses:
        use = uses[stage]
        yield from (f"{stage}.{name}=" for name in (*index.params.get(use, ()), *_TIMES))
        yield from (f"{stage}.in.{port}=" for port in index.ports.get(use, ()))


def _values(target: str, uses: Mapping[str, str], index: Index) -> Sequence[str]:
    stage, dot, param = target.partition(".")
    if not dot:
        if stage not in uses:
            return list(index.params)
        now = uses[stage]
        alike = [use for use in index.params if use.partition(".")[0] == now.partition(".")[0]]
        return alike if now in index.filters else [use for use in alike if use not in index.filters]
    if stage == "run":
        return index.run_options.get(param, [])
    if param.startswith("in."):
        return index.channels
    return index.params.get(uses.get(stage, ""), {}).get(param, [])


def paths(prefix: str, suffixes: Sequence[str] = ()) -> Iterator[str]:
    """Yield folders (with a slash behind) and the files with one of ``suffixes``, or all."""
    folder, slash, start = prefix.rpartition("/")
    with suppress(OSError):
        for path in sorted(Path(os.path.expanduser(folder + slash or ".")).iterdir()):
            if not path.name.startswith(start) or (path.name.startswith(".") and not start):
                continue
            if path.is_dir():
                yield f"{folder}{slash}{path.name}/"
            elif not suffixes or path.suffix in suffixes:
                yield f"{folder}{slash}{path.name}"


def other_computers() -> list[str]:
    """Return the hosts of the ``hosts.yaml`` in the working folder, as feeds."""
    from graphnav.core.rooms import in_room

    with suppress(GraphnavError):
        return [f"{name}:" for name in in_room("processes.hosts").named_here()]
    return []


def run_folders(prefix: str) -> Iterator[str]:
    """Yield run folders, the newest of ``runs/`` first, then other folders and logs."""
    newest: list[str] = []
    with suppress(OSError):
        found = [path.parent for path in Path(_RUNS).glob(f"*/{RunFolder.LOG}")]
        newest = list(map(str, sorted(found, key=lambda path: path.stat().st_mtime, reverse=True)[:_MAX_RUNS]))
    yield from newest
    for path in paths(prefix, (".lcmlog",)):
        folder = path.rstrip("/")
        if folder not in newest:
            yield folder if path != folder and Path(folder, RunFolder.LOG).is_file() else path


def shell_script(shell: str, program: str = "graphnav") -> str:
    """Return what one of `SHELLS` has to evaluate so that TAB completes the command line of ``program``."""
    from argcomplete.shell_integration import shellcode

    return shellcode([program], shell=shell).strip() + "\n"
