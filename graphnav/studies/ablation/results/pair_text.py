"""Read two variants as ``--contrast`` names them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from graphnav.core.errors import Problem, UserError, did_you_mean
from graphnav.studies.ablation.results.compare_pairs import Pair


def parse_pairs(texts: Sequence[str], variants: Sequence[str]) -> tuple[Pair, ...]:
    """Return the two variants of each ``A,B``; a variant's own name may contain commas.

    Raises
    ------
    UserError
        Everything that does not name two different variants of the study.
    """
    problems: list[Problem] = []
    pairs = []
    for text in texts:
        splits = [(a.strip(), b.strip()) for a, b in _splits(text)]
        found = [pair for pair in splits if pair[0] in variants and pair[1] in variants and pair[0] != pair[1]]
        if found:
            pairs.append(found[0])
        else:
            problems.append(_problem(text, splits, variants))
    if problems:
        raise UserError(problems)
    return tuple(pairs)


def _splits(text: str) -> Iterable[Pair]:
    """Yield the two parts of a string at each of its commas."""
    for place, char in enumerate(text):
        if char == ",":
            yield text[:place], text[place + 1 :]


def _problem(text: str, splits: Sequence[Pair], variants: Sequence[str]) -> Problem:
    known = f"variants of this study are {'; '.join(variants)}"
    if not splits:
        return Problem(None, f"contrast '{text}' names one variant", f"write two, A,B; {known}")
    first, second = splits[0]
    if first == second:
        return Problem(None, f"contrast '{text}' names the same variant twice", f"name two; {known}")
    unknown = first if first not in variants else second
    hint = did_you_mean(unknown, variants) or known
    return Problem(None, f"contrast '{text}': the study has no variant '{unknown}'", hint)
