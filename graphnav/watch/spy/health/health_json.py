"""The health of runs as JSON."""

from __future__ import annotations

from typing import Any

from graphnav.watch.feed import GuardHealth, Health, RunHealth
from graphnav.watch.fields.plain_values import plain


def health_as_json(health: Health, feed: str) -> dict[str, Any]:
    """Return the newest messages of every run and guard; ``silent_s`` is null for a log."""
    return {
        "feed": feed,
        "runs": [_run(health, health.runs[run_id]) for run_id in sorted(health.runs)],
        "guards": [_guard(health, health.guards[channel]) for channel in sorted(health.guards)],
    }


def _run(health: Health, run: RunHealth) -> dict[str, Any]:
    fields = None
    if run.status is not None:
        fields = plain({"utime": run.utime, "seq": run.seq, **run.status.lcm_fields()})
        for one in fields["inputs"]:
            reasons = one.pop("reasons")
            one["rejected"] = dict(zip(reasons, one["rejected"], strict=False))
            one["details"] = {reason: text for reason, text in zip(reasons, one["details"], strict=False) if text}
            del one["n_reasons"]
    return {
        "run_id": run.run_id,
        "silent": health.is_silent(run),
        "silent_s": health.silent_s(run),
        "status": fields,
    }


def _guard(health: Health, guard: GuardHealth) -> dict[str, Any]:
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
