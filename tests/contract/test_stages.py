"""Every installed stage keeps to what stages keep to."""

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.stage import ports_of
from graphnav.testing import check_stage

CATALOG = Catalog()
USES = [f"{family}.{name}" for family in CATALOG.families() for name in CATALOG.names(family)]


@pytest.mark.parametrize("use", USES)
def test_keeps_the_contract_of_stages(use: str) -> None:
    check_stage(CATALOG.stage(use))


@pytest.mark.parametrize("use", USES)
def test_only_scores_and_oracles_read_the_truth(use: str) -> None:
    stage = CATALOG.stage(use)
    reads_truth = any(port.message.is_truth for port in ports_of(stage).inputs)
    assert stage.role in ("score", "oracle") or not reads_truth


@pytest.mark.parametrize("use", [use for use in USES if use.startswith("score.")])
def test_a_score_says_so(use: str) -> None:
    assert CATALOG.stage(use).role == "score"
