"""A run into a folder: the errors that it met, its end, and its summary, whatever ends it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from graphnav.core.errors import GraphnavError
from graphnav.core.graph import Graph
from graphnav.core.interrupts import CtrlC, Interrupt, working_folder_restored
from graphnav.core.record.threaded_writer import Log
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.engine import Engine, Outcome, Sink
from graphnav.core.runner.recording.changes import Changes
from graphnav.core.runner.recording.kept_messages import kept, open_log
from graphnav.core.runner.recording.progress_file import ProgressFile
from graphnav.core.runner.recording.provenance import files_of_graphs
from graphnav.core.runner.recording.saved_graph import save_graph
from graphnav.core.runner.recording.stall import StallLimit, StallWatch, stall_error
from graphnav.core.runner.recording.summary import Summary, steps_of
from graphnav.core.runner.stage_calls import Call, StageCalls


class Measured(NamedTuple):
    """Values that a schedule adds to the `Summary` of its run."""

    sim_s: float
    wall_s: float
    behind_s: float
    tap_dropped: int
    notices: tuple[str, ...] = ()
    processes: dict[str, Any] | None = None
    live: dict[str, Any] | None = None


class RecordedRun:
    """A run in progress, into a folder that exists.

    ``close_log`` makes the log complete, ``measured`` returns what the summary tells of the run so far: both are also
    called by another thread, where a call into a stage does not return. ``changes``: what changes its stages meanwhile.
    """

    def __init__(
        self,
        graph: Graph,
        folder: Path,
        run_id: str,
        on_failure: Callable[[GraphnavError], None],
        close_log: Callable[[], None],
        measured: Callable[[], Measured],
        changes: Changes | None = None,
    ) -> None:
        self._graph, self._folder, self._run_id, self._changes = graph, folder, run_id, changes
        self._close_log, self._measured = close_log, measured
        self.failures = Failures(on_failure)
        self.outcome: str = Outcome.FAILED
        self.engine: Engine[Any] | None = None
        """The stages, once they are wired, so that there is something to summarise."""
        self._scores: dict[str, dict[str, float]] = {}

    def save_graph(self) -> None:
        """Write the graph and its plugins into the folder, so that it runs again.

        Raises
        ------
        UserError
            The folder cannot be written, or a plugin can no longer be read.
        """
        save_graph(self._graph, self._folder)

    def open_log(self, path: Path) -> Log:
        """Open the log, in one file, or in several as the graph says; raises OSError if that is not possible."""
        return open_log(self._graph.run, path)

    def kept(self, log: Sink, channels: Collection[str] | None, *, is_live: bool) -> Sink:
        """Return what takes the run's messages for its ``log``: of ``channels``, None for what the graph says."""
        return kept(self._graph, log, channels, is_live=is_live)

    def conduct(
        self,
        run: Callable[[Interrupt, StageCalls, ExitStack], None],
        stall: StallLimit | None,
        marked: Mapping[str, str],
    ) -> Summary:
        """Call ``run``, and write and return the summary.

        ``run`` wires and runs the stages, notes the calls into them, and gives what has to be closed to the stack.
        ``marked``: the stages whose calls are marked in the folder, and what they use.

        Raises
        ------
        GraphnavError
            The summary cannot be written.
        CtrlC
            The user asked for the end before the stages were wired, or after the run had reached its own.
        """
        with ProgressFile(self._folder, marked) as progress, Interrupt() as interrupt:
            calls = StageCalls(progress.mark if marked else None)
            try:
                with working_folder_restored(), ExitStack() as cleanup:
                    if stall is not None:
                        cleanup.enter_context(self._stall_watch(calls, stall, progress))
                    run(interrupt, calls, cleanup)
                    interrupt.settle()
            except CtrlC:  # while it ended, such as in a stage that does not close
                if self.engine is None:
                    raise
                self.outcome = Outcome.STOPPED
            summary = self.summarise()
            if interrupt.asked and summary.outcome not in (Outcome.STOPPED, Outcome.FAILED):
                raise CtrlC  # nothing may follow
        return summary

    def summarise(self) -> Summary:
        """Write and return the summary; raises GraphnavError if it cannot be written."""
        summary = self._summary()
        self._write(summary)
        return summary

    def read_scores(self) -> None:
        """Read the metrics of the stages, before they are closed."""
        if self.engine is not None and self.engine.is_ready:
            self._scores = Summary.scores_of(self.engine.units, self.failures.noted)

    def _stall_watch(self, calls: StageCalls, stall: StallLimit, progress: ProgressFile) -> StallWatch:
        """Return what ends the process if a call into a stage does not return."""

        def finish(call: Call) -> None:
            """Write what the thread of the run cannot write any more."""
            with self.failures.noted():
                graph = self._graph if self._changes is None else self._changes.graph
                raise stall_error(graph, call, stall.seconds, self.engine.begin_us if self.engine else 0)
            self.failures.close(self._close_log)
            summary = self._summary()
            self.failures.close(lambda: self._write(summary))
            progress.remove()
            stall.on_stall(summary)

        return StallWatch(calls, stall.seconds, finish)

    def _summary(self) -> Summary:
        measured, engine = self._measured(), self.engine
        return Summary(
            outcome=str(Outcome.FAILED if self.failures else self.outcome),
            failure=str(self.failures),
            graph=self._graph.path.stem,
            seed=self._graph.run.seed,
            until_s=self._graph.run.until_s,
            frames=engine.ticks if engine is not None else 0,
            sim_s=measured.sim_s,
            wall_s=round(measured.wall_s, 4),
            stages=steps_of(engine.units) if engine is not None else {},
            scores=self._scores,
            notices=[*self._graph.notices, *measured.notices],
            tap_dropped=measured.tap_dropped,
            run_id=self._run_id,
            versions=Summary.versions_here() | files_of_graphs([self._graph]),
            behind_s=measured.behind_s,
            cause=self.failures.cause,
            changes=[] if self._changes is None else list(self._changes.made),
            processes=measured.processes,
            live=measured.live,
        )

    def _write(self, summary: Summary) -> None:
        try:
            summary.write(self._folder / RunFolder.SUMMARY)
        except GraphnavError as error:
            raise GraphnavError(f"{error}; the log up to here is complete") from error


class Failures:
    """Collects what went wrong in a run and while it ended; ``on_failure`` gets every error as it is met."""

    def __init__(self, on_failure: Callable[[GraphnavError], None]) -> None:
        self._on_failure = on_failure
        self._found: list[GraphnavError] = []

    @contextmanager
    def noted(self) -> Iterator[None]:
        """Let an error end the block, not the run's record."""
        try:
            yield
        except GraphnavError as error:
            if not any(error is one for one in self._found):  # a log that failed says so again when it is closed
                self._found.append(error)
                self._on_failure(error)

    def close(self, close: Callable[[], None]) -> None:
        """Close something."""
        with self.noted():
            close()

    def __bool__(self) -> bool:
        return bool(self._found)

    @property
    def cause(self) -> str:
        """The causes of all failures without their times, one per line."""
        return "\n".join(error.cause for error in self._found)

    def __str__(self) -> str:
        return "\n".join(map(str, self._found))
