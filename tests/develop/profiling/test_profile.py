"""Profiles: the parts are the tick, the run is that of ``graphnav run``."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from typing import Any

import pytest

from graphnav.core.machine.console import Console
from graphnav.develop.profiling import step_functions
from graphnav.develop.profiling.profile import Profile, print_profile
from graphnav.develop.profiling.step_functions import Function, StepFunctions
from graphnav.develop.profiling.tick_spans import WARM_UP, TickKind

from .conftest import GRAPH, ProfileText

NS = 1e-6
"""A nanosecond in milliseconds: one reading of the tests' clock."""


def test_the_parts_of_a_tick_are_counted_to_the_nanosecond(profile_text: ProfileText) -> None:
    profile, spans = profile_text()
    assert spans.kinds[TickKind.WARM_UP] == WARM_UP
    assert sum(spans.kinds.values()) == 120
    # Each of 3 stages steps once and encodes one message for the log; those of count and plus are consumed.
    expected = {"step": 3, "encode": 3, "log": 3, "decode": 2, "deliver": 4, "tap": 0, "instruments": 0}
    assert {part: profile.parts[part] / NS for part in expected} == pytest.approx(expected)
    assert profile.instruments.readings - 1 == pytest.approx(profile.tick_ms / NS)


def test_the_parts_add_up_to_the_tick(profile_text: ProfileText) -> None:
    profile, _ = profile_text()
    assert sum(profile.parts.values()) == pytest.approx(profile.tick_ms, abs=1e-12)
    assert sum(stage.ms for stage in profile.stages) == pytest.approx(profile.ideal_ms, abs=1e-12)
    assert sum(one.total_us for one in profile.channels) == pytest.approx(
        1e3 * sum(profile.parts[part] for part in ("encode", "deliver", "decode", "log", "tap")), abs=1e-9
    )
    outside_ms = sum(stage.ms + stage.beyond_ms for stage in profile.stages)
    assert outside_ms < profile.tick_ms
    assert sum(stage.share for stage in profile.stages) == pytest.approx(profile.ideal_ms / profile.tick_ms)
    assert profile.tree.ms == pytest.approx(profile.tick_ms)
    assert all(node.ms >= sum(child.ms for child in node.children) - 1e-12 for node in profile.tree.walk())


def test_the_second_receiver_is_the_tap(profile_text: ProfileText) -> None:
    profile, _ = profile_text(n_sinks=2)
    assert profile.parts["tap"] / NS == pytest.approx(3)
    assert all(channel.tap_us == channel.log_us == pytest.approx(NS * 1e3) for channel in profile.channels)
    assert "tap µs" in str(profile)


def test_channels_say_how_often_they_are_sent_and_decoded(profile_text: ProfileText) -> None:
    text = GRAPH.replace("probe.counter", "probe.counter, with: {every: 2}").replace("until_s: 20", "until_s: 100")
    profile, spans = profile_text(text, 700)
    by_name = {channel.name: channel for channel in profile.channels}
    timed = spans.kinds[TickKind.TIMED]
    assert set(by_name) == {"count.twist", "plus.twist", "join.twist"}
    assert 0.4 < by_name["count.twist"].messages < 0.6  # a fixed sequence picks the timed ticks
    assert by_name["count.twist"].decodes == by_name["count.twist"].messages
    assert by_name["join.twist"].decodes == 0
    assert by_name["join.twist"].deliver_us == 0
    assert by_name["join.twist"].n_bytes == 40
    assert profile.stages[0].steps == timed
    assert profile.stages[1].steps == round(by_name["count.twist"].messages * timed)


@pytest.mark.parametrize("every", [61, 62, 63, 64])
def test_a_tick_that_fails_is_not_in_the_profile(profile_text: ProfileText, every: int) -> None:
    text = f"""\
run: {{until_s: 20}}
stages:
  count: {{use: probe.counter}}
  rare: {{use: probe.counter, with: {{every: {every}}}}}
  bad: {{use: probe.bad, with: {{at: 1}}, in: {{twist: rare}}}}
"""
    profile, spans = profile_text(text, may_fail=True)
    assert spans.kinds.total() == every  # it failed in the next one
    assert [stage.name for stage in profile.stages] == ["count", "rare"]
    assert {node.label for node in profile.tree.children} == {"count", "rare"}
    assert [(one.name, one.messages) for one in profile.channels] == [("count.twist", 1.0)]
    assert sum(profile.parts.values()) == pytest.approx(profile.tick_ms, abs=1e-12)


def test_functions_take_their_share_of_the_step(profile_text: ProfileText, monkeypatch: pytest.MonkeyPatch) -> None:
    found = Function("Plus.step", "runner/stages.py:60", 1.0, {("f", "x"): Function("f", "x", 0.25)})
    monkeypatch.setattr(StepFunctions, "of", lambda self, stage: [found] if stage == "plus" else [])
    pytest.importorskip("pyinstrument")
    profile, spans = profile_text(functions=StepFunctions())
    assert spans.kinds[TickKind.SAMPLED] > 0
    step = next(node for node in profile.tree.walk() if node.kind == "step" and node.note == "plus")
    (function,) = step.children
    assert (function.label, function.kind, function.ms) == ("Plus.step", "function", step.ms)
    assert function.children[0].ms == pytest.approx(step.ms / 4)


def test_the_sampled_functions_are_those_of_the_step(profile_text: ProfileText) -> None:
    pytest.importorskip("pyinstrument")
    text = "run: {until_s: 20}\nstages:\n  noise: {use: probe.noise, with: {rows: 2000}}\n"
    functions = StepFunctions()
    profile_text(text, 60, functions=functions)
    (step,) = functions.of("noise")
    assert step.name == "Noise.step"
    assert step.source.startswith("runner/stages.py:")
    assert step.share == pytest.approx(1.0)
    assert sum(call.share for call in step.calls.values()) <= 1.0 + 1e-9


def test_frames_of_the_sampling_itself_are_left_out() -> None:
    frames = pytest.importorskip("pyinstrument.frame")

    def frame(function: str, file: str, *children: Any) -> Any:
        return frames.Frame(f"{function}\0{file}\0001", children=children, time=1.0)

    begin, end = frame("__enter__", "contextlib.py"), frame("__exit__", "contextlib.py")
    step = frame("step", "mine.py")
    caller = frame("timed_step", step_functions._CALLER, begin, step, end)
    assert list(step_functions._below_caller(frame("run", "runner.py", caller))) == [step]


def lines_of(profile: Profile, **options: bool) -> list[str]:
    text = io.StringIO()
    print_profile(Console(file=text, highlight=False, soft_wrap=True), profile, **options)
    return text.getvalue().splitlines()


def test_the_tables_show_every_stage_channel_and_part(profile_text: ProfileText) -> None:
    profile, _ = profile_text()
    lines = lines_of(profile)
    assert lines == [*str(profile).splitlines(), *lines[len(str(profile).splitlines()) :]]
    firsts = [line.split()[0] for line in lines if line.split()]
    order = ["count", "plus", "join", "count.twist", "plus.twist", "join.twist", "steps", "runner", "tick"]
    assert [word for word in firsts if word in order] == order
    assert "tap" not in firsts


def test_a_profile_that_was_faster_with_its_instruments_says_that_this_is_noise(profile_text: ProfileText) -> None:
    profile, _ = profile_text()
    for with_ms, is_noise in ((0.9, True), (1.1, False)):
        found = replace(profile.instruments, timed_p50_ms=with_ms, bare_p50_ms=1.0)
        (line,) = [line for line in lines_of(replace(profile, instruments=found)) if line.startswith("instruments: ")]
        told = f"; median tick {with_ms:.3f} ms with, 1.000 ms without them"
        noise = ": the difference is noise, since instruments do not speed up a tick"
        assert line.partition(";")[2] == told[1:] + noise * is_noise


def test_the_slowest_rows_come_first_if_asked(profile_text: ProfileText) -> None:
    profile, _ = profile_text()
    lines = lines_of(profile, slowest_first=True)
    firsts = [line.split()[0] for line in lines if line.split()]
    channels = sorted(profile.channels, key=lambda one: -one.total_us)
    assert [word for word in firsts if ".twist" in word] == [one.name for one in channels]


def test_json_holds_the_numbers_without_the_flame_graph(profile_text: ProfileText) -> None:
    profile, _ = profile_text()
    found = json.loads(json.dumps(profile.as_json()))
    assert found["parts"].keys() == profile.parts.keys()
    assert found["ideal_ms"] == profile.ideal_ms
    assert "tree" not in found
