"""Show a run in a notebook: outcome, pictures, metrics."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator, Mapping
from itertools import zip_longest
from pathlib import Path

from markupsafe import Markup

from graphnav.core.html_templates import rendered
from graphnav.core.runner.recording.summary import Summary
from graphnav.core.stage import Metric

_COLOURS = {"goal": "#2e7d4f", "end": "#2e7d4f", "contact": "#c0392b", "failed": "#c0392b", "timeout": "#b8860b"}
Declared = Mapping[str, Mapping[str, Metric]]
"""The declared metrics of each stage, by name."""
_MAX_PICTURE_BYTES = 8 << 20
"""Larger pictures would make notebooks that viewers do not open."""


def run_html(summary: Summary, pictures: Iterable[Path], declared: Declared) -> Markup:
    """Return HTML that needs nothing else; what a stage or a graph wrote is shown as text.

    The metrics of all stages are side by side: a table that is wide, not long.
    """
    stages = {stage: _cells(metrics, declared.get(stage, {})) for stage, metrics in summary.scores.items() if metrics}
    return rendered(
        "graphnav.core.api",
        "run.html",
        summary=summary,
        colour=_COLOURS.get(summary.outcome, "inherit"),
        pictures=list(_images(pictures)),
        stages=list(stages),
        rows=list(zip_longest(*stages.values(), fillvalue=("", ""))),
    )


def _cells(metrics: dict[str, float], declared: Mapping[str, Metric]) -> list[tuple[str, str]]:
    labels = {name: declared[name].label if name in declared else name for name in metrics}
    return [(labels[name], f"{value:.4g}") for name, value in metrics.items()]


def _images(pictures: Iterable[Path]) -> Iterator[tuple[str, str]]:
    """Yield name and data of the pictures that still exist, the widest views first."""
    for path in sorted(pictures, key=lambda path: path.name, reverse=True):
        try:
            data = path.read_bytes() if path.suffix == ".png" and path.stat().st_size <= _MAX_PICTURE_BYTES else b""
        except OSError:
            continue
        if data:
            yield path.stem, base64.b64encode(data).decode()
