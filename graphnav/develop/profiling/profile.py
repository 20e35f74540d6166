"""A profile: where the time of a tick went."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import Any

from graphnav.develop.parameters import Clock
from graphnav.develop.profiling.flame import flame_svg
from graphnav.develop.profiling.text import profile_text


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
class Node:
    """A box of the flame graph: mean milliseconds of a tick, what is within it included."""

    label: str
    kind: str
    """The part, or ``function``."""
    ms: float
    note: str = ""
    children: tuple[Node, ...] = ()

    def walk(self) -> Iterator[Node]:
        """Yield this box and all within it."""
        yield self
        for child in self.children:
            yield from child.walk()


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
        return flame_svg(self)

    def __str__(self) -> str:
        return profile_text(self)

    def _repr_html_(self) -> str:
        return self.flame
