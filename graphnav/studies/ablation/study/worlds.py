"""The number of worlds of a graph, where it is not that of the study's seeds."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from graphnav.core.errors import Place, Problem
from graphnav.core.graph import suggest_graph

_PAIR = re.compile(r"\s*(.+?)\s*=\s*([1-9][0-9]{0,8})\s*", re.ASCII)


def parse_worlds(texts: Sequence[str], problems: list[Problem]) -> dict[str, int]:
    """Return what ``--worlds suite/laps=10,pillars=20`` means; what is wrong is added to ``problems``."""
    found: dict[str, int] = {}
    for text in (part for given in texts for part in given.split(",")):
        pair = _PAIR.fullmatch(text)
        if pair is None:
            hint = "write --worlds GRAPH=10"
            problems.append(Problem(Place("--worlds"), f"'{text}' is not a graph and its number of worlds", hint))
        elif pair[1] in found:
            problems.append(Problem(Place("--worlds"), f"graph '{pair[1]}' is given twice", "keep one", "duplicate"))
        else:
            found[pair[1]] = int(pair[2])
    return found


def replaced_worlds(
    old: Mapping[str, int], new: Mapping[str, int], graphs: Sequence[str], problems: list[Problem]
) -> dict[str, int]:
    """Return the numbers of worlds of a study with those of the command line; names that no graph has are problems."""
    place = Place("--worlds")
    problems += [unknown_graph(name, graphs, place) for name in new if name not in graphs]
    return {**old, **new}


def unknown_graph(name: str, graphs: Iterable[str], place: Place | None) -> Problem:
    """Return the problem of a number of worlds for a graph that the study does not have."""
    known = list(graphs)
    hint = suggest_graph(name, known) or f"its graphs are {', '.join(known)}"
    return Problem(place, f"'worlds' names '{name}', but the study has no such graph", hint)
