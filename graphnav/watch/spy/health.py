"""The health of runs and guards as text and as JSON."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from graphnav import Status
from graphnav.core.errors import shown_name
from graphnav.core.tables import Cell, Table, cut
from graphnav.watch.feed import MAX_RUNS, GuardHealth, Health, RunHealth
from graphnav.watch.fields.plain_values import plain
from graphnav.watch.spy.processes import EDGE, PROCESS, Processes, shown_host, shown_process

_FORGET_S = 10.0
"""A run that is silent for longer is shown in one line."""
_INPUT = ("input", "channel", "accepted", "lost", "rate", "age / max", "offset", "fault", "rejected")
_OUTPUT = ("output", "channel", "", "sent", "refused", "latency p50", "p99", "max", "fault")
_STAGE = ("stage", "uses", "process", "rate", "p50", "p99", "deadline", "missed", "overtaken")
_STRINGS = {
    "stage",
    "uses",
    "input",
    "channel",
    "output",
    "fault",
    "rejected",
    "process",
    "stages",
    "edge",
    "reads",
    "way",
    "host",
}
"""Columns that shrink if a table is too wide; numbers are never cut."""
_WIDE_COLS = 100
"""Narrower terminals show fewer columns."""
_WIDE_ONLY = {
    _INPUT: {"channel", "offset"},
    _OUTPUT: {"channel", "max"},
    _STAGE: {"uses", "process", "deadline"},
    PROCESS: {"stages"},
    EDGE: {"reads"},
}
_MAX_ROWS = 1000
"""Any program may send a status of any length."""
_WRAPPED = {"fault", "rejected", "host"}
_STOP = "stop"
"""The guard's cause of a stop that was requested; a stopped robot without it is held by what the guard found."""


def health_as_text(health: Health, width_cols: int) -> RenderableType:
    """Return the newest messages of guards and runs, for a terminal of ``width_cols`` columns, most important first.

    Guards come before the runs, runs with motor outputs before others, inputs and outputs before stages. Silent runs
    come last, are marked as silent, and their metrics are dim.
    """
    parts: list[RenderableType] = [_guard(health, health.guards[channel]) for channel in sorted(health.guards)]
    for run in sorted(health.runs.values(), key=lambda run: (health.is_silent(run), not _has_motor(run), run.run_id)):
        parts += _run(health, run, width_cols)
    if health.has_forgotten:
        parts.append(Text(f"only the newest {MAX_RUNS} runs and guards are kept"))
    return Group(*parts)


def _has_motor(run: RunHealth) -> bool:
    return run.status is not None and any(one["motor"] for one in run.status.outputs)


def _run(health: Health, run: RunHealth, width_cols: int) -> Iterator[RenderableType]:
    status, silent_s = run.status, health.silent_s(run) or 0.0
    heading = Text.assemble(("run ", "bold"), (shown_name(run.run_id), "bold"))
    if status is not None:
        heading.append(f"  {shown_name(status.graph)}")
    if health.is_silent(run) or status is None:
        heading.append(f"  no status for {silent_s:.1f} s", "bold red")
    if status is None:
        yield heading
        return
    yield heading.append(f"  {_clock(status)}")
    if status.log_fault:
        yield Text(f"not recording: {shown_name(status.log_fault)}", "bold red")
    if silent_s <= _FORGET_S:
        yield from _tables(status, "dim" if health.is_silent(run) else "", width_cols)


def _clock(status: Status) -> str:
    mode = "live" if status.live else f"lockstep, {status.run_s:.1f} s simulated"
    return (
        f"{mode}, {status.wall_s:.1f} s of wall time, {status.behind_s:.2f} s behind, {status.memory_mb:.0f} MB, "
        f"dropped: tap {status.tap_dropped}, log {status.log_dropped}"
    )


def _tables(status: Status, style: str, width_cols: int) -> Iterator[RenderableType]:
    processes = Processes(status)
    tables: Sequence[tuple[tuple[str, ...], Iterator[Sequence[object]]]] = (
        (_INPUT, map(_input, status.inputs)),
        (_OUTPUT, map(_output, status.outputs)),
        (PROCESS, processes.rows()),
        (_STAGE, (_stage(one, processes.of(one["name"])) for one in status.stages)),
        (EDGE, processes.edge_rows() if processes else iter(())),
    )
    for headings, all_rows in tables:
        rows = list(islice(all_rows, _MAX_ROWS))
        if rows:
            hidden = set(_WIDE_ONLY[headings] if width_cols < _WIDE_COLS else ())
            if not processes:
                hidden.add("process")
            if not processes.has_hosts:
                hidden.add("host")
            if not status.live and headings is EDGE:
                hidden.add("overtaken")
            yield _table(headings, rows, style, hidden)
        if n_more := sum(1 for _ in all_rows):
            yield Text(f"and {n_more} more", style)
        if headings is _INPUT:
            yield from (Text(line, "yellow") for one in status.inputs for line in _details(one))
    if status.edges and not processes:
        overtaken = ", ".join(f"{shown_name(edge['name'])} {edge['overtaken']}" for edge in status.edges)
        yield Text(f"overtaken on edges: {overtaken}", style)


def _stage(one: Mapping[str, Any], process: str) -> Sequence[object]:
    deadline = f"{one['deadline_ms']:.0f} ms" if one["deadline_ms"] else ""
    return (
        shown_name(one["name"]),
        shown_name(one["use"]),
        shown_process(process),
        f"{one['rate_hz']:.1f} Hz",
        _ms(one["p50_ms"]),
        _ms(one["p99_ms"]),
        deadline,
        _count(one["missed"]),
        _count(one["overtaken"]),
    )


def _input(one: Mapping[str, Any]) -> Sequence[object]:
    age = Cell("none yet", "bad")
    if one["age_s"] >= 0:
        age = Cell(f"{one['age_s']:.2f} / {one['max_age_s']:.2f} s", "bad" if one["age_s"] > one["max_age_s"] else "")
    rejected = ", ".join(f"{shown_name(why)} {n}" for why, n in zip(one["reasons"], one["rejected"], strict=False))
    return (
        shown_name(one["name"]),
        shown_name(one["channel"]),
        one["accepted"],
        _count(one["lost"]),
        f"{one['rate_hz']:.1f} Hz",
        age,
        f"{one['offset_s']:+.3f} s",
        Cell(shown_name(one["fault"]), "bad") if one["fault"] else Cell(shown_name(one["clock"]), "warning"),
        Cell(rejected, "warning"),
    )


def _details(one: Mapping[str, Any]) -> Iterator[str]:
    """Yield a line for each reason of rejections of which the newest was told in detail."""
    for reason, detail in zip(one["reasons"], one["details"], strict=False):
        if detail:
            yield f"{shown_name(one['name'])}, {shown_name(reason)}: {shown_name(detail)}"


def _output(one: Mapping[str, Any]) -> Sequence[object]:
    return (
        shown_name(one["name"]),
        shown_name(one["channel"]),
        "motor" if one["motor"] else "",
        one["sent"],
        _count(one["refused"]),
        *(_ms(one[f"latency_{name}_ms"]) if one["latency_max_ms"] else "" for name in ("p50", "p99", "max")),
        Cell(shown_name(one["fault"]), "bad"),
    )


def _guard(health: Health, guard: GuardHealth) -> Text:
    """Return one line for the guard and one per cause."""
    state = guard.state
    text = Text.assemble(("guard ", "bold"), (shown_name(guard.channel), "bold"), "  ")
    if health.is_silent(guard):
        return text.append(f"no state for {health.silent_s(guard):.1f} s", "bold red")
    move, advance = ("may move", "green"), ("may turn, not advance", "yellow")
    text.append(*(("may not move", "bold red") if not state.may_move else move if state.may_advance else advance))
    text.append(", retries slowly" if state.is_retrying else "", "yellow")
    if fault := health.motor_fault(guard):
        text.append(f", but {shown_name(fault)}", "bold red")
    text.append(", override active" if state.overridden else "")
    text.append(", stopped until it is armed again" if state.stopped else "")
    for line in state.described():
        text.append(f"\n    {shown_name(line)}")
    if state.stopped and _STOP not in state.causes:
        text.append("\n    look, then press r in graphnav teleop to let it retry, or drive it by hand", "yellow")
    return text


def _table(
    headings: Sequence[str], rows: Sequence[Sequence[object]], style: str, hidden: Collection[str]
) -> RenderableType:
    """Return a table without the columns whose headings are ``hidden``; only sentences are wrapped."""
    shown = [number for number, heading in enumerate(headings) if heading not in hidden]
    table = Table.plain((headings[n] for n in shown), [[row[n] for n in shown] for row in rows])
    return cut(table, shrinking=_STRINGS, wrapped=_WRAPPED, style=style)


def _ms(value: float) -> str:
    return f"{value:.1f} ms"


def _count(number: int) -> Cell:
    return Cell(str(number), "warning" if number else "")


def health_as_json(health: Health, feed: str) -> dict[str, Any]:
    """Return the newest messages of every run and guard; ``silent_s`` is null for a log."""
    return {
        "feed": feed,
        "runs": [_run_json(health, health.runs[run_id]) for run_id in sorted(health.runs)],
        "guards": [_guard_json(health, health.guards[channel]) for channel in sorted(health.guards)],
    }


def _run_json(health: Health, run: RunHealth) -> dict[str, Any]:
    fields = None
    if run.status is not None:
        fields = plain({"utime": run.utime, "seq": run.seq, **run.status.lcm_fields()})
        for one in fields["inputs"]:
            reasons = one.pop("reasons")
            one["rejected"] = dict(zip(reasons, one["rejected"], strict=False))
            one["details"] = {reason: text for reason, text in zip(reasons, one["details"], strict=False) if text}
            del one["n_reasons"]
        processes = Processes(run.status)
        for one, given in zip(fields["processes"], run.status.processes, strict=True):
            del one["n_stages"]
            one["host_shown"] = shown_host(given)
        for one in fields["edges"] if processes else ():
            one["processes"] = processes.way(one)
    return {
        "run_id": run.run_id,
        "silent": health.is_silent(run),
        "silent_s": health.silent_s(run),
        "status": fields,
    }


def _guard_json(health: Health, guard: GuardHealth) -> dict[str, Any]:
    state = guard.state
    causes = zip(state.causes, state.ports, state.values.tolist(), state.limits.tolist(), strict=True)
    return {
        "channel": guard.channel,
        "silent": health.is_silent(guard),
        "silent_s": health.silent_s(guard),
        "utime": guard.utime,
        "may_move": state.may_move,
        "may_advance": state.may_advance,
        "overridden": state.overridden,
        "stopped": state.stopped,
        "retrying": state.is_retrying,
        "motor_fault": health.motor_fault(guard),
        "causes": [plain(dict(zip(("cause", "port", "value", "limit"), cause, strict=True))) for cause in causes],
    }
