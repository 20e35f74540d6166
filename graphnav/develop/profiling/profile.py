"""A profile: where the time of a tick went, as data, tables and a flame graph."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import Any

from rich.text import Text

from graphnav.core.machine import Console
from graphnav.core.tables import Table, print_fitted
from graphnav.develop.parameters import Clock
from graphnav.develop.profiling.flame import Node, flame_svg

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


@dataclass(frozen=True)
class StageTime:
    """The steps of one stage. ``ms`` is its share of the mean tick; the quantiles are those of ticks in which it fired.

    ``beyond_ms``: of a tick, what its firings took in addition to the steps: checks, messages, and the runner.
    """

    name: str
    use: str
    steps: int
    ms: float
    p50_ms: float
    p99_ms: float
    share: float
    beyond_ms: float


@dataclass(frozen=True)
class ChannelTime:
    """The messages of one channel: how many a tick, their mean size, and microseconds of the mean tick by part.

    ``decodes``: decoded messages in a tick; a channel that no stage reads is not delivered.
    """

    name: str
    messages: float
    decodes: float
    n_bytes: float
    encode_us: float
    deliver_us: float
    decode_us: float
    log_us: float
    tap_us: float

    @property
    def total_us(self) -> float:
        """Everything that the channel costs in a tick."""
        return self.encode_us + self.deliver_us + self.decode_us + self.log_us + self.tap_us


@dataclass(frozen=True)
class Instruments:
    """The cost of measuring: ``readings`` of the clock in a tick, ``reading_us`` each.

    ``timed_p50_ms`` and ``bare_p50_ms``: the medians of ticks with and without them.
    """

    readings: float
    reading_us: float
    timed_p50_ms: float
    bare_p50_ms: float | None
    """None if every tick was measured."""

    @property
    def ms(self) -> float:
        """The cost in a tick by the count of readings."""
        return self.readings * self.reading_us / 1e3


@dataclass(frozen=True)
class Profile:
    """The times of a run's ticks in lockstep; ``print`` shows tables, a notebook the flame graph.

    Times are means over the timed ticks, so that parts add up to the tick.
    """

    graph: str
    seed: int
    outcome: str
    """The outcome of the run, as that of `Run`."""
    failure: str
    """The cause if the run failed; the times are those of the ticks before."""
    clock: Clock
    """``"wall"``, or ``"cpu"`` where the times are processor time."""
    ticks: dict[str, int]
    """Ticks by kind: ``timed``, ``bare`` (without instruments), ``sampled`` (functions), ``warm_up``."""
    parts: dict[str, float]
    """Milliseconds of a tick by part: ``step``, ``check``, ``encode``, ``deliver``, ``decode``, ``log``, ``tap``;
    ``instruments``, at least; and ``runner``, the remainder."""
    rate_hz: float
    """Ticks in a second of the graph's own time, 0 if none of that passed."""
    tick_ms: float
    """The mean tick, the sum of ``parts``."""
    tick_p50_ms: float
    """The median tick."""
    tick_p99_ms: float
    """The 99 % quantile."""
    stages: tuple[StageTime, ...]
    """Every stage that fired."""
    channels: tuple[ChannelTime, ...]
    """Every channel that carried a message."""
    instruments: Instruments
    """The cost of measuring."""
    threads: dict[str, int]
    """Threads of ``blas``, and of ``opencv`` where a stage has loaded it."""
    tree: Node = field(repr=False)
    """The boxes of the flame graph."""

    @property
    def ideal_ms(self) -> float:
        """The sum of the steps: a tick in which everything else costs nothing."""
        return self.parts["step"]

    @property
    def ticks_per_s(self) -> float:
        """Ticks in a second."""
        return 1e3 / self.tick_ms

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON can hold it, without the flame graph."""
        found = {name: value for name, value in asdict(self).items() if name != "tree"}
        found["instruments"]["ms"] = self.instruments.ms
        return found | {"ideal_ms": self.ideal_ms, "ticks_per_s": self.ticks_per_s}

    @property
    def flame(self) -> str:
        """The flame graph, an SVG document."""
        return flame_svg(
            self.tree,
            f"{self.graph}: a tick takes {self.tick_ms:.3f} ms, {self.ticks_per_s:.0f} ticks/s",
            f"the steps alone take {self.ideal_ms:.3f} ms, {_share(self.ideal_ms, self)} of it; "
            f"means of {self.ticks['timed']} ticks, seed {self.seed}, {CLOCKS[self.clock]}",
        )

    def __str__(self) -> str:
        text = io.StringIO()
        print_profile(Console(file=text, highlight=False, soft_wrap=True, force_jupyter=False), self)
        return text.getvalue().rstrip()

    def _repr_html_(self) -> str:
        return self.flame


def print_profile(console: Console, profile: Profile, *, slowest_first: bool = False) -> None:
    """Print what was measured, stages, channels and the sum; rows are in the graph's order, or the slowest first."""
    console.print(_amount(profile))
    for table in (_stages(profile, slowest_first), _channels(profile, slowest_first), _sum(profile)):
        if table.rows:
            print_fitted(console, table)
    for line in _notes(profile):
        console.print(line)


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
    return Table.plain(("stage", "use", *numbers), rows, right=numbers)


def _stage_cells(stage: StageTime) -> Iterator[str]:
    yield from (str(stage.steps), f"{stage.ms:.3f}", f"{stage.share:.1%}", f"{stage.p50_ms:.3f}")
    yield from (f"{stage.p99_ms:.3f}", f"{stage.beyond_ms * 1e3:.1f}")


def _channels(profile: Profile, slowest_first: bool) -> Table:  # noqa: FBT001
    has_tap = bool(profile.parts["tap"])
    times = ("encode µs", "deliver µs", "decode µs", "decodes", "log µs", *(["tap µs"] if has_tap else []), "sum µs")
    numbers = ("messages a tick", "bytes", *times)
    channels = sorted(profile.channels, key=lambda one: -one.total_us) if slowest_first else profile.channels
    rows = [(channel.name, *_channel_cells(channel, has_tap)) for channel in channels]
    return Table.plain(("channel", *numbers), rows, right=numbers)


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
    return Table.plain(("part", *numbers, ""), cells, right=numbers, n_sums=1)


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
