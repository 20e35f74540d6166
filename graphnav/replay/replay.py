"""Replay a log: play its sources, step the other stages again, compare."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

from graphnav import About, GraphnavError, Recording, UserError
from graphnav.core.codec import DecodeError, encode
from graphnav.core.errors import StageError
from graphnav.core.graph import RESERVED
from graphnav.core.interrupts import third_party_code
from graphnav.core.machine import read_json
from graphnav.core.record import LogWriter
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Engine, Failures, Summary, about_of
from graphnav.core.stage import FormerNames
from graphnav.replay.comparison.comparison import Comparison, Scope
from graphnav.replay.comparison.field_differences import Tolerance
from graphnav.replay.comparison.result import ReplayResult, Reproduced
from graphnav.replay.log.contents import read_contents
from graphnav.replay.log.log_graph import LogGraph
from graphnav.replay.log.reproduction import Reproduction, reproduction_of
from graphnav.replay.plan import make_plan
from graphnav.replay.session import live_session, lockstep_session


@dataclass(frozen=True)
class ReplayOptions:
    """Options of a replay.

    ``play``: channels to play in addition to those of sources (``stage.port``, or ``stage`` for all of its ports).
    ``from_s``: start of the comparison; ``is_cold``: also start the stages here, with fresh state, instead of warming
    them up from the beginning.
    """

    play: Sequence[str] = ()
    from_s: float = 0.0
    is_cold: bool = False
    tolerance: Tolerance = field(default_factory=Tolerance)


class Replayer(Protocol):
    """The schedule that steps the stages by a log."""

    @property
    def engine(self) -> Engine[Any]:
        """The stepping stages."""

    def reset(self, seed: int) -> None:
        """Reset every stage."""

    def replay(self) -> Iterator[int]:
        """Process the log; yield the run's clock after each part, microseconds."""

    def close(self) -> None:
        """Close the stages."""


def replay(
    recording: Recording,
    made: LogGraph,
    options: ReplayOptions,
    *,
    out: Path | None = None,
    about: About | None = None,
    on_tick: Callable[[int], None] = lambda _: None,
    on_failure: Callable[[GraphnavError], None] = lambda _: None,
) -> ReplayResult:
    """Step the stages of a graph by a log, and compare their messages with the recorded ones.

    ``out``: the file for the replay's own log, ``about`` its description, None for that of ``made``. ``on_tick`` is
    called with the time of the replayed run, microseconds, ``on_failure`` with the error of a stage that ends it.

    Raises
    ------
    UserError
        Required messages are missing, an option does not fit the log, or a stage cannot be created.
    LogError
        ``out`` cannot be written.
    """
    wall_begin_s = time.monotonic()
    work = _Replay(recording, made, options, is_logged=out is not None)
    with third_party_code(), ExitStack() as cleanup:
        log = None if out is None else cleanup.enter_context(_log_writer(out, about or work.about, work.begin_us))
        replayer = work.begin(log)
        cleanup.callback(replayer.close)
        work.step(replayer, on_tick, on_failure)
        scores = _scores(replayer, on_failure)
    return work.result(replayer, scores, time.monotonic() - wall_begin_s)


class _Replay:
    """A replay in progress, from what the log holds to how the replayed messages differ."""

    def __init__(self, recording: Recording, made: LogGraph, options: ReplayOptions, *, is_logged: bool) -> None:
        self._recording, self._made, self._options = recording, made, options
        self._contents = read_contents(recording, made.graph, made.about, made.recorded, is_live=made.is_live)
        self._reproduction = reproduction_of(made, self._contents, wants_all=is_logged)
        reproduced = self._reproduction.channels if self._reproduction is not None else ()
        self._plan = make_plan(made.graph, options.play, [channel.ref for channel in reproduced], made.changes)
        self.begin_us = recording.begin_us if made.is_live else 0
        self._from_us = self.begin_us + round(options.from_s * 1e6)
        self._done_us, self._failure = self.begin_us, ""
        self._check_reach()
        start_us = self._from_us if options.is_cold else self.begin_us
        self._session = (
            live_session(recording, made, self._plan, self._contents, start_us)
            if made.is_live
            else lockstep_session(recording, made, self._plan, self._contents, start_us, self._reproduction)
        )
        self._lost = [*self._contents.lost, *self._session.lost]
        recorded = {c.ref for c in self._plan.compared if self._contents.messages[c.name]}
        self._stages = self._plan.stepped_at_first.make_stages(made.graph.read | recorded)

    def _check_reach(self) -> None:
        """Raise UserError where nothing is left to compare."""
        path = self._recording.path
        if not self._contents.order:
            hint = "name the graph that produced it with --graph FILE, or another log"
            raise UserError.of(f"{path} holds no messages of its graph", hint)
        end_us = max(message.at_us for message in self._contents.order)
        if self._from_us > end_us:
            what = f"{path} ends at {(end_us - self.begin_us) / 1e6:.2f} s"
            raise UserError.of(what, f"--from {self._options.from_s:g} is after the end")

    @property
    def about(self) -> About:
        """The description in the log of the replay, which holds everything unless a stage is not needed."""
        graph = self._made.graph
        if graph.run.record == "replayable" and not self._plan.not_needed:
            graph = replace(graph, run=replace(graph.run, record="all"))
        return about_of(graph, is_live=self._made.is_live)

    def begin(self, log: LogWriter | None) -> Replayer:
        """Wire the stages to what compares their messages; return what steps them."""
        made = self._made
        reproduced = self._reproduction.outputs if self._reproduction is not None else ()
        compared = (*reproduced, *self._plan.compared)
        later = [channel.name for change in made.changes for channel in change.node.outputs.values()]
        recorded = (*made.about.channels, *later) if made.about is not None else None
        last_us, tolerance = self._session.last_us, self._options.tolerance
        scope = Scope(self.begin_us, self._from_us, last_us, tolerance, made.complete, recorded)
        self._new = [channel for channel in compared if recorded is not None and channel.name not in recorded]
        known = [channel for channel in compared if channel not in self._new]
        self._comparison = Comparison(self._recording, known, self._contents, scope)
        self._counts = _MessageCounts()
        replayer: Replayer = self._session.make(self._stages, [self._comparison, self._counts], log)
        self._comparison.now_us = lambda: replayer.engine.utime
        return replayer

    def step(
        self, replayer: Replayer, on_tick: Callable[[int], None], on_failure: Callable[[GraphnavError], None]
    ) -> None:
        """Go through the log, until it ends, is damaged, or a stage fails."""
        try:
            replayer.reset(self._made.graph.run.seed)
            for done_us in replayer.replay():
                self._done_us = done_us
                on_tick(done_us - self.begin_us)
        except DecodeError:
            done_s = (self._done_us - self.begin_us) / 1e6
            self._lost.append(f"replayed up to {done_s:.2f} s: the next message is damaged")
        except StageError as error:
            self._failure = str(error)
            on_failure(error)

    def result(self, replayer: Replayer, scores: dict[str, dict[str, float]], wall_s: float) -> ReplayResult:
        """Return how what was replayed differs from the log."""
        plan, contents, path = self._plan, self._contents, self._recording.path
        again = self._reproduction
        stepped = {channel.name for channel in (*plan.compared, *(again.channels if again is not None else ()))}
        played = tuple(channel.name for channel in plan.played if contents.messages[channel.name])
        replayed = (stepped | set(played)) - contents.other_types
        return ReplayResult(
            log=str(path),
            from_s=self._options.from_s,
            until_s=(self._done_us - self.begin_us) / 1e6,
            n_ticks=replayer.engine.ticks,
            is_live=self._made.is_live,
            wall_s=wall_s,
            stepped=tuple(node.name for node in plan.stepped_at_first.order),
            played=played,
            not_needed=plan.not_needed,
            reproduced=tuple(_reproduced(again)) if again is not None else (),
            channels=self._comparison.results(self._done_us if replayer.engine.ticks else self.begin_us - 1),
            new={channel.name: self._counts.of(channel.name) for channel in self._new},
            not_replayed=tuple(_not_replayed(self._recording, self._made, replayed)),
            lost=tuple(self._lost),
            failure=self._failure,
            scores=scores,
            recorded_scores=_recorded_scores(path),
        )


class _MessageCounts:
    """A sink that counts messages."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()

    def write(self, channel: str, _utime: int, _data: bytes) -> None:
        """Count one message."""
        self._counts[channel] += 1

    def of(self, channel: str) -> int:
        """Return the number of messages on a channel."""
        return self._counts[channel]


def _scores(replayer: Replayer, on_failure: Callable[[GraphnavError], None]) -> dict[str, dict[str, float]]:
    return Summary.scores_of(replayer.engine.units, Failures(on_failure).noted) if replayer.engine.is_ready else {}


def _reproduced(reproduction: Reproduction) -> Iterator[Reproduced]:
    """Yield what each source made again."""
    for node in reproduction.nodes:
        made = [channel.name for channel in node.outputs.values() if channel in reproduction.channels]
        checked = [channel.name for channel in node.outputs.values() if channel.name not in made]
        heard = [i.channel.name for i in node.inputs if i.channel is not None]
        yield Reproduced(node.name, tuple(made), tuple(heard), tuple(checked))


def _log_writer(path: Path, about: About, begin_us: int) -> LogWriter:
    if path.exists():
        raise UserError.of(f"{path} already exists", "choose another file with -o")
    try:
        writer = LogWriter(path)
    except OSError as error:
        raise UserError.of(f"cannot write {path}: {error.strerror}", "choose another file with -o") from error
    writer.write(About.CHANNEL, begin_us, encode(about, begin_us, 0))
    return writer


def _not_replayed(recording: Recording, made: LogGraph, replayed: set[str]) -> Iterator[str]:
    """Yield the recorded channels that the replay does not have."""
    for name in made.about.channels if made.about is not None else ():
        if name not in replayed and not name.startswith(RESERVED) and recording.count(name):
            yield name


def _recorded_scores(log: Path) -> dict[str, dict[str, float]]:
    """Return the metrics by stage in the summary of a run folder, empty without a readable one."""
    if log.name != RunFolder.LOG:
        return {}
    try:
        summary = read_json(log.parent / RunFolder.SUMMARY)
    except (OSError, ValueError):
        return {}
    scores = summary.get("scores") if isinstance(summary, dict) else None
    return {
        stage: {FormerNames.metric_now(name): float(value) for name, value in metrics.items() if _is_number(value)}
        for stage, metrics in (scores.items() if isinstance(scores, dict) else ())
        if isinstance(metrics, dict)
    }


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
