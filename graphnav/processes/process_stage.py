"""A stage of another process, as the engine of the run calls it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graphnav.core.errors import StageError
from graphnav.core.graph import Node
from graphnav.core.runner import Done
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
        self._utime = 0

    @property
    def is_done(self) -> bool:
        """Whether the step that was begun has ended, or never will."""
        return self._step is None or self._step.answer is not None or self._process.is_down

    def reset(self, run_seed: int) -> None:
        """Wait until the stage is reset, as all of its process are at once; raises StageError if it cannot be."""
        self._inputs = InputsSent(self._node)
        answer = self._answer_of(self._process.ordered_reset(run_seed))
        if answer is None:
            raise self._failure(0.0)
        error = unpacked_error(answer["error"])
        if error is not None and (not isinstance(error, StageError) or error.stage == self._node.name):
            raise error

    def begin(self, utime: int, inputs: Mapping[str, Any]) -> None:
        """Begin a step; messages among the inputs are `Encoded`."""
        head, messages = self._inputs.packed(inputs)
        self._utime = utime
        self._step = self._process.post(Kind.FIRE, (self._place, utime, head), messages)

    def done(self) -> Done:
        """Wait for the end of the step that was begun; raises CtrlC where the user interrupts it."""
        while not self.is_done:
            self._supervisor.wait()
        if self._step is None or self._step.answer is None:
            return Done(error=self._failure(self._utime / 1e6))
        return unpacked_done(self._node, self._step.answer)

    def metrics(self) -> dict[str, float] | None:
        """Return the metrics of the stage, None if it reports none or its process is gone; raises StageError."""
        found: dict[str, float] | None = self._called(Kind.METRICS, self._place)
        return found

    def close(self, at_s: float) -> None:
        """Close the stage, if its process is still there; raises StageError."""
        if self._process.link is not None:
            self._called(Kind.CLOSE, (self._place, at_s))

    def _called(self, kind: Kind, head: Any) -> Any:
        answer = self._answer_of(self._process.post(kind, head))
        if answer is None:
            return None
        if (error := unpacked_error(answer["error"])) is not None:
            raise error
        return answer["value"]

    def _answer_of(self, request: Request) -> Any:
        """Wait for an answer; None if the process is gone."""
        while request.answer is None and not self._process.is_down:
            self._supervisor.wait()
        return None if request.answer is None else request.answer.head

    def _failure(self, at_s: float) -> StageError:
        return StageError(self._node.name, self._node.use, at_s, self._process.failure, self._process.hint)
