"""Format the result of a replay for the terminal."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rich.console import Group
from rich.text import Text

from graphnav.core.machine import Console
from graphnav.core.tables import Cell, Table, fitted
from graphnav.replay.comparison.result import ChannelResult, FirstDifference, ReplayResult, Reproduced

_MAX_CHARS = 40


def as_text(result: ReplayResult, console: Console) -> Group:
    """Return the verdict, one line per channel, the fields that differ, and metrics with their recorded values.

    Tables fit the console, in blocks of columns.
    """
    tables = [_channels(result.channels)]
    if any(channel.fields for channel in result.channels.values()):
        tables.append(_fields(result.channels))
    changed = dict(_changed_metrics(result))
    if changed:
        tables.append(_metrics(changed))
    blocks = [block for table in tables for block in fitted(console, table)]
    lines = []
    n_equal = sum(map(len, result.scores.values())) - sum(map(len, changed.values()))
    if n_equal:
        lines.append(Text(f"{_count(n_equal, 'metric')} as recorded"))
    if result.new:
        counts = (f"{name} ({_count(number, 'message')})" for name, number in result.new.items())
        lines.append(Text(f"new, not compared: {', '.join(counts)}"))
    if result.not_needed:
        lines.append(Text(f"not needed: {', '.join(result.not_needed)}"))
    if result.not_replayed:
        lines.append(Text(f"in the log, not in the replay: {', '.join(map(_quoted, result.not_replayed))}"))
    lines += [Text(_unlike(one, names), style="red") for one, names in result.unlike]
    return Group(_headline(result), *blocks, *lines, _verdict(result))


def _headline(result: ReplayResult) -> Text:
    ratio = result.until_s / result.wall_s if result.wall_s else 0.0
    begin = f", compared from {result.from_s:g} s" if result.from_s else ""
    counted = "firings" if result.is_live else "ticks"
    return Text(
        f"{result.until_s:.1f} s replayed in {result.wall_s:.1f} s ({ratio:.1f} x), {result.n_ticks} {counted}{begin}\n"
        f"played: {', '.join(result.played)}\nstepped: {', '.join(result.stepped)}"
        + "".join(f"\n{_reproduced(one)}" for one in result.reproduced)
    )


def _reproduced(one: Reproduced) -> str:
    inputs = f" with the recorded {', '.join(one.inputs)}" if one.inputs else ""
    return f"reproduced: {', '.join(one.channels)}, by stepping {one.stage}{inputs}"


def _unlike(one: Reproduced, names: Sequence[str]) -> str:
    differing = ", ".join(names)
    return (
        f"{', '.join(one.channels)} may not be as in the run: {one.stage} does not make {differing} as recorded; "
        "replay on the kind of machine and with the versions of the run's summary.json"
    )


def _verdict(result: ReplayResult) -> Text:
    compared = sum(channel.n_compared for channel in result.channels.values())
    counted = f"{_count(compared, 'message')} on {_count(len(result.channels), 'channel')} compared"
    if result.first is None and result.failure:
        return Text("failed", style="bold red").append(
            f", no differences until then: {counted}", style="default not bold"
        )
    if result.first is None:
        return Text("no differences", style="bold green").append(f": {counted}", style="default not bold")
    name, first = result.first
    differing = sum(not channel.is_equal for channel in result.channels.values())
    text = Text(f"{_count(differing, 'channel')} of {len(result.channels)} differ", style="bold red")
    return text.append(f": first {name} at {first.at_us / 1e6:.2f} s, {_said(first)}", style="default not bold")


def _channels(channels: Mapping[str, ChannelResult]) -> Table:
    has_unrecorded = any(channel.n_not_recorded for channel in channels.values())
    numbers = ("differ", "max abs", "missing", "extra", *(["not logged"] if has_unrecorded else []))
    rows = []
    for name, channel in channels.items():
        cells = [
            name,
            _at(channel.first),
            _share(channel.n_differing, channel.n_compared),
            _gap(channel.max_gap),
            str(channel.n_missing),
            str(channel.n_extra),
            *([str(channel.n_not_recorded)] if has_unrecorded else []),
        ]
        rows.append([Cell(text, "" if channel.is_equal else "bad") for text in cells])
    return Table.plain(("channel", "first at", *numbers), rows, right=numbers)


def _fields(channels: Mapping[str, ChannelResult]) -> Table:
    rows: list[Sequence[object]] = []
    for name, channel in channels.items():
        if channel.fields:
            rows.append([Cell(name, "strong"), *[""] * 5])
        for path, found in channel.fields.items():
            first = found.first
            cells = [
                f"  {path}{_where(first)}",
                _at(first),
                _value(first.recorded),
                _value(first.replayed),
                str(found.n_messages),
                _gap(found.max_gap),
            ]
            rows.append(cells)
    numbers = ("differ", "max abs")
    return Table.plain(("field", "first at", "recorded", "replayed", *numbers), rows, right=numbers)


def _changed_metrics(result: ReplayResult) -> Iterator[tuple[str, dict[str, tuple[float | None, float]]]]:
    """Yield the metrics of each stage that differ from the recorded run, with the recorded values."""
    for stage, metrics in result.scores.items():
        recorded = result.recorded_scores.get(stage, {})
        pairs = {name: (recorded.get(name), value) for name, value in metrics.items()}
        changed = {name: pair for name, pair in pairs.items() if not _is_same(*pair)}
        if changed:
            yield stage, changed


def _is_same(recorded: float | None, replayed: float) -> bool:
    """Whether a metric is as recorded; a summary has null for non-finite values."""
    return recorded == replayed or (recorded is None and not math.isfinite(replayed))


def _metrics(changed: Mapping[str, Mapping[str, tuple[float | None, float]]]) -> Table:
    rows = []
    for stage, metrics in changed.items():
        for place, (name, (recorded, replayed)) in enumerate(metrics.items()):
            old = "" if recorded is None else f"{recorded:.6g}"
            rows.append(("" if place else stage, name, old, f"{replayed:.6g}"))
    return Table.plain(("stage", "metric", "recorded", "replayed"), rows, right=("recorded", "replayed"))


def _said(first: FirstDifference) -> str:
    if first.kind == "missing":
        return "a message that the replay did not publish"
    if first.kind == "extra":
        return "a message that the recorded run did not publish"
    return f"{first.field}{_where(first)}: recorded {_value(first.recorded)}, replayed {_value(first.replayed)}"


def _where(first: FirstDifference) -> str:
    return f"[{', '.join(map(str, first.where))}]" if first.where else ""


def _at(first: FirstDifference | None) -> str:
    return f"{first.at_us / 1e6:.2f} s" if first else ""


def _share(count: int, of: int) -> str:
    return f"{count} of {of}" + (f" ({100 * count / of:.3g} %)" if count else "")


def _value(value: Any) -> str:
    text = f"{value:.6g}" if isinstance(value, float) else _quoted(value) if isinstance(value, str) else ascii(value)
    return text if len(text) <= _MAX_CHARS else f"{text[:_MAX_CHARS]}..."


def _quoted(text: str) -> str:
    """Return an untrusted string without control characters."""
    return json.dumps(text)[1:-1]


def _gap(gap: float | None) -> str:
    return "" if gap is None else f"{gap:.3g}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
