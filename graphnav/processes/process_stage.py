"""A stage of another process, as the engine of the run calls it."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import Any

from graphnav.core.errors import StageError
from graphnav.core.graph import Node
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
