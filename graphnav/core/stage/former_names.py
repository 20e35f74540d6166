"""Names of version 0.1.0 and what they are called now.

Applied to what earlier versions recorded: run folders, logs, study folders. In graphs, maps and studies, a former name
is refused with the new one as the suggestion.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar


class FormerNames:
    """Names of version 0.1.0 by kind, with those of today."""

    METRICS: ClassVar[Mapping[str, str]] = {"least_clearance_m": "min_clearance_m"}
    """Of stages' metrics, without the stage's name."""

    REPLACED_METRICS: ClassVar[Mapping[str, str]] = {"barn": "sct"}
    """Of stages' metrics that no longer exist, and what to use: recorded ones keep their names, since they measure
    something else."""

    ROLES: ClassVar[Mapping[str, str]] = {"control": "baseline"}
    STAGE_ATTRIBUTES: ClassVar[Mapping[str, str]] = {"less_is_better": "metrics"}
    STUDY_KEYS: ClassVar[Mapping[str, str]] = {"figures": "metrics"}

    ZERO_IF_FAILED: ClassVar = ("success", "spl", "barn")
    """The metrics that counted as 0 for a run in which a stage failed, when that was not declared."""
    OUTCOME: ClassVar = "success"
    """The metric that told whether a drive arrived, when that was not declared."""

    @classmethod
    def metric_now(cls, name: str) -> str:
        """Return what ``metric`` or ``stage.metric`` is called now."""
        stage, dot, metric = name.rpartition(".")
        return f"{stage}{dot}{cls.METRICS.get(metric, metric)}"
