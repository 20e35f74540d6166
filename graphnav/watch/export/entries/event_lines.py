"""The events of a run as lines of text: contact, goal, guard decisions, stops, notices, the outcome."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from graphnav import About, GuardState, Message, Recording, State, Stop, UserError
from graphnav.core.machine import read_json
from graphnav.core.run_folder import RunFolder
from graphnav.core.spec import parse_yaml
from graphnav.watch.export.entries.entries import Level, Line

LINE_TYPES: tuple[type[Message], ...] = (State, Stop, GuardState)
"""The messages that may cause a line."""


class Lines:
    """Converts messages to lines whenever their content has changed since the previous message."""

    def __init__(self) -> None:
        self._told: dict[tuple[str, str], Any] = {}

    def of(self, channel: str, utime: int, message: Message) -> Iterator[Line]:
        """Yield the lines for changes in a message."""
        if isinstance(message, State):
            if self._is_new(channel, "contact", now=message.contact, before=False) and message.contact:
                yield Line(utime, Level.ERROR, "contact", channel)
            if self._is_new(channel, "goal", now=message.at_goal, before=False) and message.at_goal:
                yield Line(utime, Level.INFO, "goal reached", channel)
        elif isinstance(message, Stop):
            text = "stop requested" if message.engaged else "armed again"
            level = Level.WARNING if message.engaged else Level.INFO
            yield Line(utime, level, f"{text}: {message.reason}" if message.reason else text, channel)
        elif isinstance(message, GuardState):
            now = (message.may_move, message.may_advance, message.overridden, message.causes, message.ports)
            is_free = message.may_move and not message.is_retrying
            level = Level.INFO if is_free else Level.WARNING
            if self._is_new(channel, "guard", now=now, before=(True, True, False, (), ())):
                yield Line(utime, level, _guard_text(message), channel)

    def _is_new(self, channel: str, what: str, *, now: Any, before: Any) -> bool:
        """Whether a value differs from the previous one, initially ``before``."""
        changed = bool(self._told.get((channel, what), before) != now)
        self._told[channel, what] = now
        return changed


def heading(about: About | None) -> str:
    """Return a line from the description of a run, empty without one."""
    if about is None:
        return ""
    try:
        graph = parse_yaml(about.graph_yaml.encode(), About.CHANNEL)[0].plain()
    except UserError:
        graph = None
    description = graph.get("about") if isinstance(graph, dict) else None
    text = str(description or "").strip()
    return " ".join(part for part in (text, f"(seed {about.seed})") if part)


def outcome_lines(recording: Recording, begin_us: int, end_us: int) -> Iterator[Line]:
    """Yield the notices and the outcome in the run folder's summary; nothing without a summary."""
    summary = _summary_beside(recording.path)
    notices = summary.get("notices")
    for notice in notices if isinstance(notices, list) else ():
        yield Line(begin_us, Level.INFO, str(notice), RunFolder.SUMMARY)
    if failure := summary.get("failure"):
        yield Line(end_us, Level.ERROR, str(failure), RunFolder.SUMMARY)
    if outcome := summary.get("outcome"):
        level = Level.ERROR if outcome in ("failed", "contact") else Level.INFO
        yield Line(end_us, level, f"outcome: {outcome}", RunFolder.SUMMARY)


def _guard_text(state: GuardState) -> str:
    what = "allows all motion" if state.may_advance else "forbids forward motion"
    if not state.may_move:
        what = "forbids motion"
    if state.is_retrying:
        what = "retries slowly"
    if state.overridden:
        what = "is overridden"
    causes = [f"{cause} {port}".strip() for cause, port in zip(state.causes, state.ports, strict=False)]
    return f"guard {what}" + (f": {', '.join(causes)}" if causes else "")


def _summary_beside(log: Path) -> dict[str, Any]:
    try:
        found = read_json(log.with_name(RunFolder.SUMMARY))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}
