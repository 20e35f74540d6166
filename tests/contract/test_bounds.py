"""Every number of every stage has bounds: what no machine could mean is refused before a run."""

from __future__ import annotations

from typing import get_args

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import ParamError
from graphnav.core.stage import Param, params_of

CATALOG = Catalog()
USES = [f"{family}.{name}" for family in CATALOG.families() for name in CATALOG.names(family)]


def _takes(param: Param, value: float) -> bool:
    try:
        param.parse(value)
    except ParamError:
        return False
    return True


@pytest.mark.parametrize("use", USES)
def test_extreme_numbers_are_refused(use: str) -> None:
    for param in params_of(CATALOG.stage(use)).values():
        if float in (param.type, *get_args(param.type)):
            taken = [value for value in (1e308, -1e308, 1e13, -1e13, 1e-300, -1e-300) if _takes(param, value)]
            assert not taken, f"{param.name} takes {taken}"
