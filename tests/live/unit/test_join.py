"""Which messages belong together, and which set is taken."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav.core.runner.join import MAX_UNMATCHED, Held, Join


def held(name: str = "", birth_s: float = 0.0, arrived_s: float = 0.0) -> Held:
    """Return a message that waits."""
    return Held(name, birth_s, arrived_s)


def test_the_newest_complete_set_is_taken_and_older_ones_are_overtaken() -> None:
    join = Join(["flow", "planar"])
    for utime in (1, 2, 3):
        join.put("flow", utime, held(f"f{utime}"))
    for utime in (1, 2):
        join.put("planar", utime, held(f"p{utime}"))
    taken = join.take(join.complete()[0])
    assert {port: one.message for port, one in taken.held.items()} == {"flow": "f2", "planar": "p2"}
    assert dict(join.overtaken) == {"flow": 1, "planar": 1}
    assert join.n_waiting == 1  # f3 waits for its partner
    join.put("planar", 3, held("p3"))
    assert join.take(join.complete()[0]).utime == 3


def test_a_branch_slower_than_a_period_still_meets_the_other() -> None:
    join = Join(["fast", "slow"])
    met = 0
    for k in range(600):
        join.put("fast", k, held())
        if k >= 3:
            join.put("slow", k - 3, held())
        for utime in join.complete()[:1]:
            join.take(utime)
            met += 1
    assert met == 597


def test_unmatched_messages_are_bounded_and_the_oldest_goes_first() -> None:
    join = Join(["flow", "planar"])
    for utime in range(20):
        join.put("flow", utime, held())
    assert join.n_waiting == MAX_UNMATCHED
    assert join.overtaken["flow"] == 20 - MAX_UNMATCHED
    join.put("planar", 19, held())
    assert join.complete() == [19]


def test_a_join_whose_sets_wait_for_a_busy_stage_matches() -> None:
    join, apart = Join(["flow", "motion"]), Join(["flow", "motion"])
    for utime in range(MAX_UNMATCHED):
        for port, shift in (("flow", 0), ("motion", 1000)):
            join.put(port, utime, held())
            apart.put(port, utime + shift, held())
    assert not join.never_matches
    assert apart.never_matches


def test_in_order_every_complete_set_is_taken() -> None:
    join = Join(["flow"], max_unmatched=None, in_order=True)
    for utime in range(50):
        join.put("flow", utime, held())
    taken = [join.take(join.complete()[0]).utime for _ in range(50)]
    assert taken == list(range(50))
    assert not join.overtaken.total()


def test_a_set_is_as_old_as_its_oldest_part_and_ready_when_its_last_came() -> None:
    join = Join(["flow", "planar"])
    join.put("flow", 5, held(birth_s=1.0, arrived_s=1.5))
    join.put("planar", 5, held(birth_s=0.9, arrived_s=1.7))
    taken = join.take(5)
    assert (taken.birth_s, taken.ready_s) == (0.9, 1.7)


@settings(derandomize=True, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(["a", "b"]), st.integers(0, 30), st.booleans()), max_size=200))
def test_stamps_only_advance_and_every_message_is_accounted_for(events: list[tuple[str, int, bool]]) -> None:
    join = Join(["a", "b"])
    put, used, last, known = 0, 0, -1, set()
    for port, utime, take in events:
        if utime > last and (port, utime) not in known:
            known.add((port, utime))
            join.put(port, utime, held())
            put += 1
        if take and (complete := join.complete()):
            last = join.take(complete[0]).utime
            used += 2
    assert put == used + join.overtaken.total() + join.n_waiting
