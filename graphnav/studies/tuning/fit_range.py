"""Fit a range of ``--search`` to the parameter that it names: its type and its bounds."""

from __future__ import annotations

from dataclasses import replace

from graphnav.core.errors import ParamError, Place, Problem, UserError
from graphnav.core.stage import Param
from graphnav.studies.tuning.search_range import SearchRange, plain_type


def fitted(searched: SearchRange, param: Param) -> SearchRange:
    """Return a range with the type of its parameter: ``1:4`` of a float has all numbers from 1 to 4.

    Raises
    ------
    UserError
        An end or a choice that the parameter may not have: every trial of it would be refused.
    """
    place = Place(f"--search {searched.text}")
    problems = []
    for value in searched.choices or (searched.low, searched.high):
        try:
            param.parse(value)
        except ParamError as error:
            bounds = f", {param.bounds_text}" if param.bounds_text else ""
            problems.append(Problem(place, error.what, error.hint or f"'{param.name}' is {param.type_text}{bounds}"))
    if problems:
        raise UserError(problems)
    if searched.kind == "choice":
        return searched
    return replace(searched, kind="integer" if plain_type(param.type) is int else "number")
