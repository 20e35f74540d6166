"""The stopwatch: every nanosecond belongs to one span."""

from __future__ import annotations

from collections.abc import Iterable

from hypothesis import given
from hypothesis import strategies as st

from graphnav.develop.profiling.stopwatch import Part, Span, Stopwatch


def watch_at(times_ns: Iterable[int]) -> Stopwatch:
    return Stopwatch(iter(times_ns).__next__)


def spans(span: Span) -> list[Span]:
    return [span, *(inner for child in span.children.values() for inner in spans(child))]


def test_a_span_has_its_time_without_that_of_spans_within() -> None:
    watch = watch_at([100, 107, 120, 150, 151, 160])
    watch.begin()
    watch.enter(Part.STAGE, "plane")
    watch.enter(Part.ENCODE, "plane.plane")
    watch.leave()
    watch.leave()
    watch.end()
    stage = watch.root.children[Part.STAGE, "plane"]
    encode = stage.children[Part.ENCODE, "plane.plane"]
    assert (watch.root.ns, stage.ns, encode.ns) == (7 + 9, 13 + 1, 30)
    assert (watch.root.count, stage.count, encode.count) == (1, 1, 1)


def test_a_lap_takes_the_time_since_the_last_boundary() -> None:
    watch = watch_at([0, 5, 12, 20])
    watch.begin()
    watch.lap(Part.DELIVER, "a")
    watch.lap(Part.DELIVER, "b")
    watch.end()
    assert [span.ns for span in spans(watch.root)] == [8, 5, 7]


def test_a_tick_that_does_not_end_leaves_no_trace() -> None:
    watch = watch_at(range(0, 1000, 10))
    watch.begin()
    watch.enter(Part.STAGE, "plane")
    watch.enter(Part.CHECK, "plane")
    watch.begin()
    watch.end()
    assert watch.n_ticks == 1
    assert [(span.ns, span.count) for span in spans(watch.root)] == [(10, 1), (0, 0), (0, 0)]


@given(st.lists(st.tuples(st.sampled_from(["enter", "leave", "lap"]), st.integers(0, 10**9)), max_size=60))
def test_the_spans_of_a_tick_add_up_to_it(moves: list[tuple[str, int]]) -> None:
    now_ns = 0

    def clock() -> int:
        return now_ns

    watch = Stopwatch(clock)
    watch.begin()
    for number, (move, passed_ns) in enumerate(moves):
        now_ns += passed_ns
        match move:
            case "enter":
                watch.enter(Part.STAGE, f"s{number % 3}")
            case "leave":
                watch.leave()
            case _:
                watch.lap(Part.DELIVER, "c")
    now_ns += 1
    watch.end()
    assert sum(span.ns for span in spans(watch.root)) == now_ns
    assert min(span.ns for span in spans(watch.root)) >= 0
