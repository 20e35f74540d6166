"""Read the overrides of a study's file, each with its location."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from graphnav.core.errors import Place, Problem, UserError
from graphnav.core.graph import Override, Target, parse_override
from graphnav.core.spec import Value
from graphnav.studies.ablation.study.study_keys import Settings


@dataclass(frozen=True)
class OverrideReader:
    """Reads the overrides of one file in ``folder``; adds what is wrong to ``problems``."""

    folder: Path
    problems: list[Problem]

    def mapping(self, settings: Settings) -> tuple[Override, ...]:
        """Return the overrides of targets and their values."""
        found = []
        for text, value in settings.items():
            if isinstance(value.data, dict):
                what = f"the value of '{text}' is a mapping"
                self.problems.append(Problem(value.place, what, "write stage.parameter: value"))
            elif (target := self.target(text, value.place)) is not None:
                found.append(self.override(target, value))
        return tuple(found)

    def texts(self, texts: Mapping[str, Place]) -> tuple[Override, ...]:
        """Return the overrides of strings ``target=value``."""
        return tuple(self._texts(texts.items()))

    def target(self, text: str, place: Place) -> Target | None:
        """Return a target, None where it is not one."""
        try:
            return Target.parse(text, place)
        except UserError as error:
            self.problems.extend(error.problems)
            return None

    def override(self, target: Target, value: Value) -> Override:
        """Return the override of a target by a value of the file."""
        return Override(target, value.plain(), value.place, self.folder)

    def _texts(self, texts: Iterable[tuple[str, Place]]) -> Iterable[Override]:
        for text, place in texts:
            try:
                yield replace(parse_override(text, place), folder=self.folder)
            except UserError as error:
                self.problems.extend(error.problems)
