"""The seeds of a study, and graphs that have only the first of them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from graphnav import Place, Problem, UserError
from graphnav.core.graph import suggest_graph

MAX_SEED = 4_294_967_295
MAX_SEEDS = 100_000

_RANGE = re.compile(r"\s*([0-9]{1,12})\s*:\s*([0-9]{1,12})\s*", re.ASCII)
_LIST = re.compile(r"\s*(\[)?\s*([0-9]{1,12}(?:\s*,\s*[0-9]{1,12})*)\s*(?(1)\])\s*", re.ASCII)
HINT = "write FIRST:END, the end not included (0:50 are 50 worlds), or a list as [1, 5, 7]"


def parse_seeds(text: str, place: Place | None = None) -> tuple[int, ...]:
    """Return the seeds that ``1000:1050`` (the end not included), ``[1, 5, 7]`` or ``1,5,7`` means.

    Raises
    ------
    UserError
        There is no seed in it, a duplicate, something else, or too many.
    """
    if found := _RANGE.fullmatch(text):
        first, end = int(found[1]), int(found[2])
        if first == end:
            raise UserError.of(
                f"'{text}' has no seed in it: the end is not included", f"write {first}:{end + 1} for one", place
            )
        if first > end:
            raise UserError.of(f"'{text}' ends before it begins", f"write {end}:{first}", place)
        if end - first > MAX_SEEDS:
            raise _too_many(end - first, place)
        return checked_seeds(range(first, end), place)
    listed = _LIST.fullmatch(text)
    if listed is None:
        raise UserError.of(f"'{text}' is not a range or a list of seeds", HINT, place)
    words = listed[2].split(",")
    if len(words) == 1 and not listed[1]:
        raise bare_number(words[0].strip(), place)
    return checked_seeds([int(word) for word in words], place)


def checked_seeds(seeds: Sequence[int], place: Place | None = None) -> tuple[int, ...]:
    """Return seeds that can be used, each once.

    Raises
    ------
    UserError
        There are none or too many, a duplicate, or one out of bounds.
    """
    if not seeds:
        raise UserError.of("there is no seed in the list", HINT, place)
    if len(seeds) > MAX_SEEDS:
        raise _too_many(len(seeds), place)
    for seed in seeds:
        if not 0 <= seed <= MAX_SEED:
            raise UserError.of(f"a seed must be from 0 to {MAX_SEED}, not {seed}", "write another", place)
    twice = [seed for seed, times in Counter(seeds).items() if times > 1]
    if twice:
        hint = "keep one: the same world twice adds nothing"
        raise UserError.of(f"duplicate seed {twice[0]}", hint, place)
    return tuple(seeds)


def seeds_words(seeds: str | Sequence[int]) -> str:
    """Return seeds as ``--seeds`` takes them."""
    if isinstance(seeds, str):
        return seeds
    if isinstance(seeds, range) and seeds.step == 1:
        return f"{seeds.start}:{seeds.stop}"
    return f"[{', '.join(map(str, seeds))}]"


def bare_number(word: str, place: Place | None = None) -> UserError:
    """Return the error for a number alone, which may mean a world or how many."""
    hint = f"write 0:{word} for {word} world{'s' if word != '1' else ''}, or [{word}] for that one"
    return UserError.of(f"'{word}' may be one seed or a number of worlds", hint, place)


def _too_many(number: int, place: Place | None) -> UserError:
    return UserError.of(f"these are {number} seeds, and a study has at most {MAX_SEEDS}", "take fewer", place)


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
