"""A run as a notebook shows it: how it ended, the pictures, the metrics."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path

from graphnav.runner.recording.summary import Summary
from graphnav.stage import Metric

_COLOURS = {"goal": "#2e7d4f", "end": "#2e7d4f", "contact": "#c0392b", "failed": "#c0392b", "timeout": "#b8860b"}
_STYLE = 'style="max-width:100%;max-height:480px;display:block"'
_MAX_PICTURE_BYTES = 8 << 20
"""Larger pictures would make a notebook that no viewer opens."""


def run_html(summary: Summary, pictures: Iterable[Path], declared: Mapping[str, Mapping[str, Metric]]) -> str:
    """Return HTML that needs nothing else; what a stage or a graph wrote is shown as text."""
    return "".join(
        [
            f"<div>{_headline(summary)}",
            f"<pre>{escape(summary.failure)}</pre>" if summary.failure else "",
            *map(_notice, summary.notices),
            *_images(pictures),
            _metrics(summary, declared),
            "</div>",
        ]
    )


def _headline(summary: Summary) -> str:
    colour = _COLOURS.get(summary.outcome, "inherit")
    counted = "ticks" if summary.live is None else "firings"
    return (
        f'<p><b>{escape(summary.graph)}</b>: <b style="color:{colour}">{escape(summary.outcome)}</b> after '
        f"{summary.sim_s:.1f} s, {summary.frames} {counted}, seed {summary.seed}, "
        f"{summary.wall_s:.1f} s of wall time</p>"
    )


def _notice(notice: str) -> str:
    return f"<p><small>{escape(notice)}</small></p>"


def _images(pictures: Iterable[Path]) -> Iterator[str]:
    """Yield the pictures that are still there, the widest views first."""
    for path in sorted(pictures, key=lambda path: path.name, reverse=True):
        try:
            data = path.read_bytes() if path.suffix == ".png" and path.stat().st_size <= _MAX_PICTURE_BYTES else b""
        except OSError:
            continue
        if data:
            source = f"data:image/png;base64,{base64.b64encode(data).decode()}"
            yield f'<img alt="{escape(path.stem)}" src="{source}" {_STYLE}/>'


def _metrics(summary: Summary, declared: Mapping[str, Mapping[str, Metric]]) -> str:
    """Return the metrics, the stages side by side: a table that is wide, not long."""
    stages = {
        stage: [(_label(declared.get(stage, {}).get(name), name), value) for name, value in metrics.items()]
        for stage, metrics in summary.scores.items()
        if metrics
    }
    if not stages:
        return ""
    head = "".join(f'<th colspan="2" style="text-align:left">{escape(stage)}</th>' for stage in stages)
    n_rows = max(map(len, stages.values()))
    rows = ("".join(_cells(metrics, row) for metrics in stages.values()) for row in range(n_rows))
    return f"<table><tr>{head}</tr>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"


def _label(metric: Metric | None, name: str) -> str:
    return metric.label if metric else name


def _cells(metrics: Sequence[tuple[str, float]], row: int) -> str:
    if row >= len(metrics):
        return "<td></td><td></td>"
    name, value = metrics[row]
    return f'<td style="text-align:left">{escape(name)}</td><td style="text-align:right">{value:.4g}</td>'
