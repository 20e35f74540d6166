"""The target of an override: a stage, a parameter, a wire, a run option, or a stage to add."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from graphnav.core.errors import Place, UserError

TargetKind = Literal["stage", "add", "setting", "wire", "run"]

_ADD, _WIRE, _RUN = "+", "in.", "run"
HINT = "write stage=family.stage, stage.parameter=value, stage.in.port=stage.port, run.key=value or name+=family.stage"
"""The forms of an override."""


@dataclass(frozen=True)
class Target:
    """The target of an override: the part of a graph that it changes."""

    kind: TargetKind
    """A stage, a stage to add, a parameter or a time of a stage, an input of a stage, an option of the run."""
    stages: tuple[str, ...] = ()
    """One or several; empty for an option of the run."""
    key: str = ""
    """The parameter, time, input port or option; empty for a stage."""

    @classmethod
    def parse(cls, text: str, place: Place) -> Target:
        """Read ``plane``, ``plane,twin.rule``, ``plane.in.flow``, ``run.seed`` or ``twin+``.

        Raises
        ------
        UserError
            It has none of these forms; reported at ``place``.
        """
        names, dot, key = text.partition(".")
        if not names or (dot and not key):
            raise UserError.of("this sets nothing", HINT, place)
        stages = tuple(names.removesuffix(_ADD).split(","))
        if names.endswith(_ADD) and not dot:
            return cls("add", stages)
        if names == _RUN:
            if not dot:
                raise UserError.of(f"'{_RUN}' is not a stage", "write run.key=value", place)
            return cls("run", key=key)
        if not dot:
            return cls("stage", stages)
        if key.endswith(_ADD):
            what = f"'{_ADD}=' adds a stage, and '{text.removesuffix(_ADD)}' is not the name of one"
            raise UserError.of(what, "write name+=family.stage", place)
        if key.startswith(_WIRE):
            return cls("wire", stages, key.removeprefix(_WIRE))
        return cls("setting", stages, key)

    @property
    def is_stage(self) -> bool:
        """Whether it is a stage, to swap or to add."""
        return self.kind in {"stage", "add"}

    @property
    def each(self) -> tuple[Target, ...]:
        """The same of one stage each: ``plane,twin.rule`` is the rule of two stages."""
        return tuple(Target(self.kind, (stage,), self.key) for stage in self.stages) or (self,)

    def __str__(self) -> str:
        names = ",".join(self.stages)
        match self.kind:
            case "stage":
                return names
            case "add":
                return f"{names}{_ADD}"
            case "wire":
                return f"{names}.{_WIRE}{self.key}"
            case "run":
                return f"{_RUN}.{self.key}"
            case "setting":
                return f"{names}.{self.key}"
