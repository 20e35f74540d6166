"""A profile as tables for the terminal."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich.text import Text

from graphnav.core.machine import Console
from graphnav.core.tables import Table, plain_table, print_table

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
        if table.rows:
            print_table(console, table)
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


def _stages(profile: Profile, slowest_first: bool) -> Table:  # noqa: FBT001
    numbers = ("steps", "ms a tick", "share", "step p50 ms", "p99 ms", "beyond the step µs")
    stages = sorted(profile.stages, key=lambda stage: -stage.ms) if slowest_first else profile.stages
    rows = [(stage.name, stage.use, *_stage_cells(stage)) for stage in stages]
    return plain_table(("stage", "use", *numbers), rows, right=numbers)


def _stage_cells(stage: StageTime) -> Iterator[str]:
    yield from (str(stage.steps), f"{stage.ms:.3f}", f"{stage.share:.1%}", f"{stage.p50_ms:.3f}")
    yield from (f"{stage.p99_ms:.3f}", f"{stage.beyond_ms * 1e3:.1f}")


def _channels(profile: Profile, slowest_first: bool) -> Table:  # noqa: FBT001
    has_tap = bool(profile.parts["tap"])
    times = ("encode µs", "deliver µs", "decode µs", "decodes", "log µs", *(["tap µs"] if has_tap else []), "sum µs")
    numbers = ("messages a tick", "bytes", *times)
    channels = sorted(profile.channels, key=lambda one: -one.total_us) if slowest_first else profile.channels
    rows = [(channel.name, *_channel_cells(channel, has_tap)) for channel in channels]
    return plain_table(("channel", *numbers), rows, right=numbers)


def _channel_cells(channel: ChannelTime, has_tap: bool) -> Iterator[str]:  # noqa: FBT001
    yield from (f"{channel.messages:.3g}", f"{channel.n_bytes:.0f}")
    yield from (f"{channel.encode_us:.1f}", f"{channel.deliver_us:.1f}", f"{channel.decode_us:.1f}")
    yield from (f"{channel.decodes:.3g}", f"{channel.log_us:.1f}")
    if has_tap:
        yield f"{channel.tap_us:.1f}"
    yield f"{channel.total_us:.1f}"


def _sum(profile: Profile) -> Table:
    parts = {part: ms for part, ms in profile.parts.items() if part != "step" and (ms or part == "runner")}
    ideal_ms = profile.ideal_ms
    rate = f"{1e3 / ideal_ms:.0f}" if ideal_ms else ""
    quantiles = f"p50 {profile.tick_p50_ms:.3f} ms, p99 {profile.tick_p99_ms:.3f} ms"
    rows = [("steps", ideal_ms, rate, "the ideal: only the steps")]
    rows += [(part, ms, "", _PARTS[part]) for part, ms in parts.items()]
    rows.append(("tick", profile.tick_ms, f"{profile.ticks_per_s:.0f}", quantiles))
    numbers = ("ms a tick", "share", "ticks/s")
    cells = [(part, f"{ms:.3f}", _share(ms, profile), rate, said) for part, ms, rate, said in rows]
    return plain_table(("part", *numbers, ""), cells, right=numbers, n_sums=1)


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
