"""A source ends a run by one of three words."""

import pytest

from graphnav import Finished


def test_the_outcome_is_kept_with_what_is_published_last() -> None:
    finished = Finished("goal", "outputs")
    assert (finished.outcome, finished.outputs) == ("goal", "outputs")


def test_another_word_is_refused() -> None:
    with pytest.raises(ValueError, match="a source cannot end a run with 'failed': use goal, contact, end"):
        Finished("failed")  # type: ignore[arg-type]
