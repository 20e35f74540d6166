"""Answer a shell that asks for completions."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import Any

from graphnav import GraphnavError
from graphnav.core.parameters import Candidates, Completer
from graphnav.develop.completion.index import Index
from graphnav.develop.completion.index_cache import installed_index
from graphnav.develop.completion.overrides import override_candidates
from graphnav.develop.completion.paths import paths, run_folders

_YAML = (".yaml", ".yml")
_Finder = Callable[[str, list[str], Index], Iterable[str]]
"""Of a prefix, the graphs and studies of the command line, and the index."""


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
    "graphs": _graphs,
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
