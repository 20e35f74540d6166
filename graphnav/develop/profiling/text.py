"""A profile as tables for the terminal."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich import box
from rich.table import Table
from rich.text import Text

from graphnav.core.machine import Console, fitted_tables

if TYPE_CHECKING:
    from graphnav.develop.parameters import Clock
    from graphnav.develop.profiling.profile import ChannelTime, Profile, StageTime

CLOCKS: dict[Clock, str] = {"wall": "wall time", "cpu": "processor time of the thread"}
_FEW = 30
_PARTS = {
    "check": "types of outputs, NaN",
    "encode": "messages to bytes",
    "deliver": "LCM, from publish to the handler",
    "decode": "bytes to messages",
    "log": "",
    "tap": "",
    "runner": "the remainder: firing rule, inputs, queues",
    "instruments": "of this measurement, at least",
}


def print_profile(console: Console, profile: Profile, *, slowest_first: bool = False) -> None:
    """Print what was measured, stages, channels and the sum; rows are in the graph's order, or the slowest first."""
    console.print(_amount(profile))
    for table in (_stages(profile, slowest_first), _channels(profile, slowest_first), _sum(profile)):
        if table.row_count:
            for block in fitted_tables(console, table):
                console.print(block, soft_wrap=True)
    for line in _notes(profile):
        console.print(line)


def profile_text(profile: Profile) -> str:
    """Return what `print_profile` prints."""
    text = io.StringIO()
    print_profile(Console(file=text, highlight=False, soft_wrap=True, force_jupyter=False), profile)
    return text.getvalue().rstrip()


def _amount(profile: Profile) -> Text:
    counts = profile.ticks
    said = {
        "warm_up": "to warm up",
        "bare": "without instruments",
        "sampled": "for the functions inside of the steps",
    }
    others = ", ".join(f"{counts[kind]} {what}" for kind, what in said.items() if counts.get(kind))
    n_threads = ", ".join(f"{name} {number}" for name, number in profile.threads.items())
    text = Text(f"{profile.graph}: {counts['timed']} timed ticks of {sum(counts.values())}")
    text.append(f" ({others}), seed {profile.seed}; threads: {n_threads}; {CLOCKS[profile.clock]}")
    return text


def _table(first: str, *numbers: str) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column(first, no_wrap=True)
    for number in numbers:
        table.add_column(number, justify="left" if number in {"use", ""} else "right", no_wrap=True)
    return table


def _stages(profile: Profile, slowest_first: bool) -> Table:  # noqa: FBT001
    table = _table("stage", "use", "steps", "ms a tick", "share", "step p50 ms", "p99 ms", "beyond the step µs")
    stages = sorted(profile.stages, key=lambda stage: -stage.ms) if slowest_first else profile.stages
    for stage in stages:
        table.add_row(Text(stage.name), Text(stage.use), *_stage_cells(stage))
    return table


def _stage_cells(stage: StageTime) -> Iterator[str]:
    yield from (str(stage.steps), f"{stage.ms:.3f}", f"{stage.share:.1%}", f"{stage.p50_ms:.3f}")
    yield from (f"{stage.p99_ms:.3f}", f"{stage.beyond_ms * 1e3:.1f}")


def _channels(profile: Profile, slowest_first: bool) -> Table:  # noqa: FBT001
    has_tap = bool(profile.parts["tap"])
    times = ("encode µs", "deliver µs", "decode µs", "decodes", "log µs", *(["tap µs"] if has_tap else []), "sum µs")
    table = _table("channel", "messages a tick", "bytes", *times)
    channels = sorted(profile.channels, key=lambda one: -one.total_us) if slowest_first else profile.channels
    for channel in channels:
        table.add_row(Text(channel.name), *_channel_cells(channel, has_tap))
    return table


def _channel_cells(channel: ChannelTime, has_tap: bool) -> Iterator[str]:  # noqa: FBT001
    yield from (f"{channel.messages:.3g}", f"{channel.n_bytes:.0f}")
    yield from (f"{channel.encode_us:.1f}", f"{channel.deliver_us:.1f}", f"{channel.decode_us:.1f}")
    yield from (f"{channel.decodes:.3g}", f"{channel.log_us:.1f}")
    if has_tap:
        yield f"{channel.tap_us:.1f}"
    yield f"{channel.total_us:.1f}"


def _sum(profile: Profile) -> Table:
    table = _table("part", "ms a tick", "share", "ticks/s", "")
    rows = {part: ms for part, ms in profile.parts.items() if part != "step" and (ms or part == "runner")}
    last = next(reversed(rows))
    ideal_ms = profile.ideal_ms
    rate = f"{1e3 / ideal_ms:.0f}" if ideal_ms else ""
    table.add_row("steps", f"{ideal_ms:.3f}", _share(ideal_ms, profile), rate, "the ideal: only the steps")
    for part, ms in rows.items():
        table.add_row(part, f"{ms:.3f}", _share(ms, profile), "", _PARTS[part], end_section=part == last)
    table.add_row(
        "tick",
        f"{profile.tick_ms:.3f}",
        _share(profile.tick_ms, profile),
        f"{profile.ticks_per_s:.0f}",
        f"p50 {profile.tick_p50_ms:.3f} ms, p99 {profile.tick_p99_ms:.3f} ms",
    )
    return table


def _share(ms: float, profile: Profile) -> str:
    return f"{ms / profile.tick_ms:.1%}" if profile.tick_ms else ""


def _notes(profile: Profile) -> Iterator[Text]:
    found = profile.instruments
    text = Text(
        f"instruments: {found.readings:.0f} clock readings a tick at {found.reading_us:.2f} µs, about {found.ms:.3f} ms"
    )
    if found.bare_p50_ms is not None:
        text.append(f"; median tick {found.timed_p50_ms:.3f} ms with, {found.bare_p50_ms:.3f} ms without them")
        if found.timed_p50_ms < found.bare_p50_ms:
            text.append(": the difference is noise, since instruments do not speed up a tick")
    yield text
    if profile.ticks["timed"] < _FEW:
        yield Text(f"quantiles of {profile.ticks['timed']} ticks are rough: let it run longer")
