"""Read the metrics of a recorded run from the summary in its folder."""

from __future__ import annotations

from pathlib import Path

from graphnav.core.machine import read_json
from graphnav.core.run_folder import RunFolder
from graphnav.core.stage import FormerNames


def recorded_scores(log: Path) -> dict[str, dict[str, float]]:
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
