"""The stage: parameters, state and ``step``."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar, Final, Literal, NamedTuple, Self, dataclass_transform, get_args

from graphnav.core.errors import ParamError
from graphnav.core.messages.message import Message
from graphnav.core.stage.metric import Metric
from graphnav.core.stage.param import param, params_of
from graphnav.core.stage.port import ports_of

Ending = Literal["goal", "contact", "end"]
"""The outcomes with which a source ends a run."""

Role = Literal["method", "baseline", "oracle", "score"]
"""Role of a stage in a comparison: a method, a baseline that a method has to beat, an oracle that sees the truth, a
score that only measures. True data (`Message.is_truth`) reaches oracles and scores alone; no stage reads a score."""

MAY_READ_TRUTH: Final[tuple[Role, ...]] = ("oracle", "score")
"""The roles of stages that may read true data."""


class Unnoticed(NamedTuple):
    """A fault that a guard cannot notice while one of its inputs is not wired."""

    port: str
    """The sampled input."""
    types: tuple[type[Message], ...]
    """Told where the guard's inputs are made from a message of one of these types."""
    fault: str
    """The fault, for a notice: ``cannot notice {fault}``."""


@dataclass_transform(kw_only_default=True, eq_default=False)
class Stage:
    """A processing step of a graph: messages in, messages out.

    Parameters are class fields declared with `param`; ports are the annotations of ``step``, which a subclass
    defines; state lives in ``_underscored`` attributes assigned in `reset`. A stage knows no bus, clock or network, so
    that tests call it directly::

        smooth = Smooth(alpha=0.3)
        smooth.reset(seed=0)
        mean = smooth.step(flow)

    An output that costs time and is declared ``T | None`` may be left out where nothing reads it, as `is_read` says::

        def step(self, image: Image) -> Outputs:
            found = self._detect(image)
            return Outputs(boxes=found, heat=self._heat(found) if self.is_read("heat") else None)
    """

    role: ClassVar[Role] = "method"
    """Its role in comparisons, shown in tables. A graph is refused in which a method or a baseline reads true data, or
    any stage reads an output of a score."""
    metrics: ClassVar[tuple[Metric, ...]] = ()
    """The metrics that `summary` returns."""
    is_guard: ClassVar[bool] = False
    """Whether it stops the robot on late, lost or blind inputs: only a guard may write a motor channel."""
    is_agent: ClassVar[bool] = False
    """Whether what it publishes is decided outside of the graph, as by a learner: a log keeps it, a replay plays it."""
    unnoticed: ClassVar[tuple[Unnoticed, ...]] = ()
    """Faults that a guard cannot notice where inputs of it are not wired, told where it writes a motor channel."""

    ports_from: ClassVar[tuple[str, ...]] = ()
    """Parameters that declare its ports, if ``step`` does not: `with_ports` gets them."""

    _read_ports: frozenset[str] | None = None
    _run_seed: int | None = None
    _wake: Callable[[], None] | None = None

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Make the annotated fields of ``cls`` parameters of its constructor."""
        super().__init_subclass__(**kwargs)
        dataclasses.dataclass(kw_only=True, eq=False)(cls)

    def __post_init__(self) -> None:
        """Convert and check the parameters.

        Raises
        ------
        ParamError
            A value has the wrong type or is out of bounds.
        """
        for name, declared in params_of(type(self)).items():
            value = getattr(self, name)
            try:
                setattr(self, name, declared.parse(value))
            except ParamError:
                if value is not declared.default:
                    raise

    @classmethod
    def with_ports(cls, **params: Any) -> type[Self]:  # noqa: ARG003
        """Return the subclass whose ``step`` has the ports that the parameters of ``ports_from`` declare.

        Called where a graph is loaded, before anything is wired, for a stage that names such parameters, with all of
        them. The same ports give the same class.

        Raises
        ------
        ParamError
            They declare no ports; shown at the parameter's location in the graph.
        ExceptionGroup
            Several `ParamError` of this kind, all of which are shown.
        """
        return cls

    def reset(self, seed: int) -> None:
        """Initialise the state; all randomness derives from ``seed``."""

    def check(self) -> None:
        """Check the files and devices that the parameters name, before the run starts.

        Raises
        ------
        ParamError
            One of them cannot be used; shown at the parameter's location in the graph.
        ExceptionGroup
            Several of them cannot be used: a `ParamError` for each, all of which are shown.
        """

    def is_read(self, port: str) -> bool:
        """Return whether a stage or an entry of ``outputs:`` reads this output of ``step``; True outside of a graph.

        It is known before `check`. The other outputs must not depend on it.

        Raises
        ------
        ValueError
            ``step`` has no such output.
        """
        names = [output.name for output in ports_of(type(self)).outputs]
        if port not in names:
            raise ValueError(f"{type(self).__qualname__} has no output '{port}': use {', '.join(names) or 'none'}")
        return self._read_ports is None or port in self._read_ports

    def patience_s(self) -> float:
        """Return how long a live firing waits for `Since` inputs to reach its stamp; called after `reset`."""
        return 0.1

    def summary(self) -> Mapping[str, float]:
        """Return the values of the declared ``metrics``, by name; one that is not defined for this run is left out."""
        return {}

    def close(self) -> None:
        """Release what `reset` or `step` opened; called once after the last step, also after a failure."""


class Source(Stage):
    """A stage fired by the clock instead of a message: a world, a video, a camera.

    Its ``step`` may take `Latest` inputs and a `Stamp`, nothing else. It ends the run with `Finished`.
    """

    reproducible: ClassVar[tuple[str, ...]] = ()
    """Outputs that it makes again, byte for byte, when it is stepped with its seed and the recorded inputs: in lockstep
    ``record: replayable`` leaves them out. At least one other output is recorded, and compared when that is done."""

    rate_hz: float = param(10.0, gt=0.0, le=10_000.0, doc="firings per second")

    def run_seed(self, seed: int) -> int:
        """Return the seed of the run, for worlds that are numbered by it; called in `reset` with its ``seed``.

        All randomness derives from that ``seed``, which is another one for every stage; outside of a graph they are the
        same.
        """
        return seed if self._run_seed is None else self._run_seed

    def is_remote(self) -> bool:
        """Return whether it reads from another machine: only a run asks it for data, neither `check` nor ``doctor``."""
        return False

    def rate(self) -> float:
        """Return firings per second; called after `reset`."""
        return self.rate_hz

    def due_us(self, firing: int) -> int:
        """Return when a firing is due, in microseconds after the first one, which is firing 0; called after `reset`.

        By default firings are ``1 / rate()`` apart. A source that plays a recording returns the recorded times, which
        increase; after the last one it returns any later time.
        """
        return round(firing * 1e6 / self.rate())


class LiveSource(Source):
    """A source fired by what arrives from outside, at its own time: a camera. A graph that has one runs live.

    Something beside the run receives, as a thread that `reset` starts; it keeps the newest data and calls `wake`. The
    run asks `arrived_s`, and ``step`` publishes what that told of. None of them may wait for the device.
    """

    def arrived_s(self) -> float | None:
        """Return when the data that the next step publishes was taken, in seconds of `time.monotonic`.

        None if none has arrived since the last step. It is asked any number of times between two steps, and a step
        publishes what the last answer told of, with that time as its stamp; so the times of steps increase.
        """
        raise NotImplementedError

    def wake(self) -> None:
        """Let the run ask `arrived_s` at once; without it, it asks 20 times a second. For any thread."""
        if self._wake is not None:
            self._wake()

    def notices(self) -> Iterable[str]:
        """Return what became of the device since the last call, a line each, for the user; asked once a second."""
        return ()

    def is_remote(self) -> bool:
        """Return True: only a run asks it for data."""
        return True


class Finished(Exception):  # noqa: N818 - it is not an error
    """Raised by a source's ``step`` to end the run; ``outputs`` are published first.

    ``outcome``: "goal", "contact" or "end" (the data is exhausted). Raises ValueError for any other.
    """

    def __init__(self, outcome: Ending, outputs: Any = None) -> None:
        super().__init__(outcome)
        if outcome not in get_args(Ending):
            raise ValueError(f"a source cannot end a run with '{outcome}': use {', '.join(get_args(Ending))}")
        self.outcome = outcome
        self.outputs = outputs


def tell_readers(stage: Stage, ports: Iterable[str]) -> None:
    """Tell a stage which of its outputs are read; `Stage.is_read` then answers by them."""
    stage._read_ports = frozenset(ports)  # noqa: SLF001, authors of stages only ask


def tell_run_seed(stage: Stage, seed: int) -> None:
    """Tell a stage the seed of the run; `Source.run_seed` then returns it."""
    stage._run_seed = seed  # noqa: SLF001, authors of stages only ask


def tell_wake(stage: LiveSource, wake: Callable[[], None]) -> None:
    """Tell a stage how to wake the run; `LiveSource.wake` then calls it."""
    stage._wake = wake  # noqa: SLF001, authors of stages only ask
