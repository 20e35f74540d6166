"""Writers fire before readers, ties keep the file's order, and what cannot fire is a loop that is named."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from graphnav.core.graph.wiring.firing import firing_order

GRAPHS = st.integers(1, 8).flatmap(
    lambda n: st.fixed_dictionaries(
        {f"s{i}": st.lists(st.sampled_from([f"s{j}" for j in range(n)]), max_size=3) for i in range(n)}
    )
)


@given(GRAPHS)
def test_every_writer_comes_before_its_readers(writers: dict[str, list[str]]) -> None:
    order, loops = firing_order(writers)
    for position, stage in enumerate(order):
        assert set(writers[stage]) <= set(order[:position])
    assert len(set(order)) == len(order)
    assert bool(loops) == (len(order) < len(writers))


@given(GRAPHS)
def test_a_loop_follows_the_wires_and_returns(writers: dict[str, list[str]]) -> None:
    order, loops = firing_order(writers)
    for loop in loops:
        assert loop[0] == loop[-1]
        assert len(set(loop)) == len(loop) - 1
        assert not set(loop) & set(order)
        assert all(one in writers[following] for one, following in pairwise(loop))


def test_ties_keep_the_order_of_the_file() -> None:
    assert firing_order({"d": ["a"], "b": ["a"], "a": [], "c": ["a"]}) == (["a", "d", "b", "c"], [])


def test_a_loop_begins_with_the_stage_that_is_first_in_the_file() -> None:
    assert firing_order({"x": [], "b": ["a"], "a": ["c"], "c": ["b"]}) == (["x"], [["b", "c", "a", "b"]])
