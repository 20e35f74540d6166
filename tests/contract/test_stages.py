"""Every installed stage keeps to what stages keep to."""

import pytest

from graphnav import Map, State, Truth
from graphnav.catalog import Catalog
from graphnav.stage import ports_of
from graphnav.testing import check_stage

CATALOG = Catalog()
USES = [f"{family}.{name}" for family in CATALOG.families() for name in CATALOG.names(family)]


@pytest.mark.parametrize("use", USES)
def test_keeps_the_contract_of_stages(use: str) -> None:
    check_stage(CATALOG.stage(use))


@pytest.mark.parametrize("use", USES)
def test_only_scores_and_oracles_read_the_truth(use: str) -> None:
    family = use.partition(".")[0]
    reads = {port.message for port in ports_of(CATALOG.stage(use)).inputs}
    may = family == "score" or CATALOG.stage(use).role == "oracle"
    assert may or not reads & {Truth, State, Map}
