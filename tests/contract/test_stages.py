"""Every installed stage keeps to what stages keep to."""

import pytest

from graphnav.catalog import Catalog
from graphnav.testing import check_stage

CATALOG = Catalog()
USES = [f"{family}.{name}" for family in CATALOG.families() for name in CATALOG.names(family)]


@pytest.mark.parametrize("use", USES)
def test_keeps_the_contract_of_stages(use: str) -> None:
    check_stage(CATALOG.stage(use))
