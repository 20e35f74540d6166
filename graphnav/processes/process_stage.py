"""A stage of another process, as the engine of the run calls it."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from typing import Any

from graphnav import Graph, Problem
from graphnav.core.errors import StageError
from graphnav.core.graph import Node, part_yaml
from graphnav.core.runner import Done, LiveStep
from graphnav.processes.frames import Kind
from graphnav.processes.stage_process import Request, StageProcess
from graphnav.processes.step_frames import InputsSent, unpacked_done, unpacked_error
from graphnav.processes.supervisor import Supervisor


class ProcessStage:
    """A `RemoteStage`: the stage at ``place`` of a process."""

    def __init__(self, process: StageProcess, place: int, supervisor: Supervisor) -> None:
        self._process, self._place, self._supervisor = process, place, supervisor
        self._node: Node = process.nodes[place]
        self._inputs = InputsSent(self._node)
        self._step: Request | None = None
        self._prepared: Request | None = None
        self._changed: Request | None = None
        self._utime = 0
        self._restarts = 0
        self.patience_s = 0.0
        """How long a live firing waits for `Since` inputs, known when it is reset."""

    @property
    def is_done(self) -> bool:
        """Whether the step that was begun has ended, or never will."""
        step = self._step
        return step is None or step.answer is not None or step.is_lost or self._process.is_down

    @property
    def is_free(self) -> bool:
        """Whether its process is there, has been reset and has nothing to do, so that a step would begin at once."""
        return self._process.is_free

    @property
    def is_there(self) -> bool:
        """Whether its process is there and has been reset."""
        return self._process.is_there

    @property
    def restarts(self) -> int:
        """How often its process was started again."""
        return self._process.restarts

    def failure(self, at_s: float) -> StageError | None:
        """Return why its process is gone for good, None if it is not."""
        return self._failure(at_s) if self._process.is_down else None

    def reset(self) -> None:
        """Wait until the stage is reset, as all of its process are at once; raises StageError if it cannot be."""
        self._inputs = InputsSent(self._node)
        answer = self._answer_of(self._process.ordered_reset(self._supervisor.order))
        if answer is None:
            raise self._failure(0.0)
        error = unpacked_error(answer["error"])
        if error is not None and (not isinstance(error, StageError) or error.stage == self._node.name):
            raise error
        if error is None:
            self.patience_s = answer["value"][self._place]

    def begin(self, utime: int, inputs: Mapping[str, Any], live: LiveStep | None) -> None:
        """Begin a step; messages among the inputs are `Encoded`. ``live``: None in lockstep."""
        if live is not None and self._process.restarts > self._restarts:
            self._restarts, self._inputs = self._process.restarts, InputsSent(self._node)
        head, messages = self._inputs.packed(inputs)
        self._utime = utime
        self._step = self._process.post(Kind.FIRE, (self._place, utime, head, live), messages)

    def done(self) -> Done:
        """Wait for the end of the step that was begun; raises CtrlC where the user interrupts it."""
        while not self.is_done:
            self._supervisor.wait()
        if self._step is None or self._step.answer is None:
            return Done(error=self._failure(self._utime / 1e6))
        return unpacked_done(self._node, self._step.answer)

    def prepare(self, graph: Graph) -> None:
        """Begin to make and reset the stage as another graph has it, beside the one that steps."""
        if self._process.part.host is not None:
            return  # `prepared` refuses it
        node = graph.node(self._node.name)
        self._prepared = self._process.prepare(
            {
                "place": self._place,
                "graph": part_yaml(graph, [node.name]),
                "read": sorted(graph.read),
                "versions": self._supervisor.versions_of(node),
            }
        )

    def prepared(self) -> Sequence[Problem] | None:
        """Return why what was prepared cannot take over, empty if it can, None while that is not known."""
        self._supervisor.wait(0.0)
        request, name = self._prepared, self._process.part.name
        stays = f"stage '{self._node.name}' ({self._node.use}) stays as it is"
        if (host := self._process.part.host) is not None:
            return [Problem(None, f"{stays}: it lives on the host {host}", "change the graph on both, and start again")]
        assert request is not None, "it was asked for"
        if self._process.is_down:
            return [Problem(None, f"{stays}: {self._process.failure}", self._process.hint)]
        if request.is_lost:
            return [Problem(None, f"{stays}: its process '{name}' ended meanwhile", "ask again")]
        if request.answer is None:
            return None
        return [Problem(None, what, hint) for what, hint in request.answer.head["problems"]]

    def drop_prepared(self) -> None:
        """Forget what was prepared: it does not take over."""
        request, self._prepared = self._prepared, None
        if request is not None:
            self._process.drop(request)

    def change(self, graph: Graph, utime: int) -> None:
        """Let what was prepared make all further steps; ``utime``: the clock."""
        request, self._prepared = self._prepared, None
        assert request is not None, "it is prepared"
        assert request.answer is not None, "it is prepared"
        told = request.answer.head
        self._node, self.patience_s = graph.node(self._node.name), told["patience_s"]
        self._inputs = InputsSent(self._node)
        self._supervisor.note_change(self._process, graph, told["versions"])
        head = {**request.head, "versions": self._supervisor.versions_of(self._node), "utime": utime}
        self._changed = self._process.change(request, head)

    def unclosed(self) -> Sequence[StageError] | None:
        """Return what the stage before the last change raised when it was closed, None while that is not known."""
        self._supervisor.wait(0.0)
        request = self._changed
        if request is None or request.is_lost or self._process.is_down:
            return ()
        if request.answer is None:
            return None
        errors = [unpacked_error(error) for error in request.answer.head["value"]]
        return [error for error in errors if isinstance(error, StageError)]

    def metrics(self) -> dict[str, float] | None:
        """Return the metrics of the stage, None if it reports none or its process is gone; raises StageError."""
        found: dict[str, float] | None = self._called(Kind.METRICS, self._place)
        return found

    def close(self, at_s: float) -> None:
        """Close the stage, if its process is still there; raises StageError."""
        if self._process.link is not None:
            self._called(Kind.CLOSE, (self._place, at_s))

    def _called(self, kind: Kind, head: Any) -> Any:
        answer = self._answer_of(self._process.post(kind, head), within_s=self._supervisor.answer_within_s)
        if answer is None:
            return None
        if (error := unpacked_error(answer["error"])) is not None:
            raise error
        return answer["value"]

    def _answer_of(self, request: Request, within_s: float | None = None) -> Any:
        """Wait for an answer; None if the process is gone, which it is if the answer does not come in time."""
        end_s = math.inf if within_s is None else time.monotonic() + within_s
        while request.answer is None and not request.is_lost and not self._process.is_down:
            if (left_s := end_s - time.monotonic()) <= 0:
                self._supervisor.end(self._process.part.name, f"it did not answer within {within_s:g} s")
                break
            self._supervisor.wait(left_s if math.isfinite(left_s) else None)
        return None if request.answer is None else request.answer.head

    def _failure(self, at_s: float) -> StageError:
        return StageError(self._node.name, self._node.use, at_s, self._process.failure, self._process.hint)
