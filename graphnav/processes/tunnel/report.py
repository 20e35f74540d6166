"""Sums of messages that a tunnel has carried and dropped, for the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from graphnav.core.cli import counted
from graphnav.core.errors import shown_name
from graphnav.core.machine import NOTABLE_OFFSET_S, SET_ALIKE, offset_text, set_text
from graphnav.core.runner import size_text
from graphnav.core.tables import Table
from graphnav.processes.host_clock import ClockState, OwnClock, read_clocks
from graphnav.processes.host_link import HostLink, Refusal
from graphnav.processes.tunnel.outbox import Accounts, Passed
from graphnav.processes.tunnel.tunnel import MAX_LINKS, Tunnel

_MAX_NAMED = 5
_MAX_ROWS = 100
_FATE = f"what comes from there has its stamps, and live inputs count an offset below max_age_s as age: {SET_ALIKE}"
_LOSSES = {"dropped": "dropped", "thinned": "above their rate", "held": "on motor channels that are not named"}


class Report:
    """Tells what has changed since it was asked last."""

    def __init__(self, tunnel: Tunnel) -> None:
        self._tunnel = tunnel
        self._lost: dict[tuple[str, str], Passed] = {}
        self._refused: dict[Refusal, int] = {}
        self._packets = self._overruns = 0
        self._own = OwnClock()
        self._clocks: dict[HostLink, ClockState] = {}
        """As last seen, of the newest connections."""

    def sums(self) -> str:
        """Return how much came and left, in a line."""
        came, left, _ = self._tunnel.accounts()
        return f"in {_sum(came)}; out {_sum(left)}"

    def losses(self) -> str:
        """Return in a line what was not carried since the last call, by channel; empty if there is nothing."""
        lost = _lost(self._tunnel)
        parts = []
        for name, text in _LOSSES.items():
            news = {
                key: n
                for key, passed in lost.items()
                if (n := getattr(passed, name) - getattr(self._lost.get(key, Passed()), name)) > 0
            }
            if news:
                parts.append(f"{sum(news.values()):,} {text}: {_named(news)}")
        self._lost = lost
        packets = self._tunnel.bus.dropped_packets()
        if packets > self._packets:
            parts.append(f"{packets - self._packets:,} packets of this group dropped by the kernel")
            self._packets = packets
        if self._tunnel.n_overruns > self._overruns:
            parts.append("this computer is too slow for all that is sent here: more may be lost without being counted")
            self._overruns = self._tunnel.n_overruns
        return "; ".join(parts)

    def clocks(self) -> str:
        """Return in a line which clocks were set, or are now far from this machine's, since the last call."""
        parts = []
        if own_s := self._own.look(read_clocks()):
            parts.append(f"the clock of this machine {set_text(own_s)}")
        for link in self._open():
            state, before = link.clock_state(), self._clocks.pop(link, None)
            if state is None:
                continue
            self._clocks[link] = state
            if state.n_steps > (0 if before is None else before.n_steps):
                parts.append(f"the clock of {link.peer} {set_text(state.step_s)}")
            if _is_apart(state) and not (before is not None and _is_apart(before)):
                parts.append(f"{_clock(link, state)}: {_FATE}")
        while len(self._clocks) > MAX_LINKS:
            self._clocks.pop(next(iter(self._clocks)))
        return "; ".join(parts)

    def clock_lines(self) -> list[str]:
        """Return a line for the clock of each connection; where none is open for the last ones."""
        links = self._open() or self._clocks
        return [_clock(link, self._clocks[link]) for link in links if link in self._clocks]

    def _open(self) -> list[HostLink]:
        return [end.link for end in self._tunnel.ends]

    def refusals(self) -> str:
        """Return in a line which connections were closed since the last call; empty if none were."""
        links = self._tunnel.links
        news = {reason: n - self._refused.get(reason, 0) for reason, n in links.refused.items()}
        self._refused = dict(links.refused)
        parts = [f"{n:,} {reason} (last {links.last_refused[reason]})" for reason, n in news.items() if n]
        return f"closed connections: {', '.join(parts)}" if parts else ""

    def table(self) -> Table:
        """Return the channels, and what was carried and lost of each."""
        came, left, _ = self._tunnel.accounts()
        carried = {("in", name): one for name, one in came.channels.items()}
        carried |= {("out", name): one for name, one in left.channels.items()}
        lost = _lost(self._tunnel)
        rows = []
        for way, name in sorted(carried.keys() | lost.keys(), key=lambda key: (key[1], key[0]))[:_MAX_ROWS]:
            one, gone = carried.get((way, name), Passed()), lost[way, name]
            counts = (one.passed, gone.dropped, gone.thinned, gone.held, gone.refused)
            passed, *others = (f"{n:,}" for n in counts)
            rows.append((shown_name(name), way, passed, size_text(one.n_bytes), *others))
        header = ("channel", "way", "messages", "size", "dropped", "above rate", "motor", "refused")
        return Table.plain(header, rows)

    def n_further_rows(self) -> int:
        """Return how many rows `table` leaves out."""
        return max(0, len(_lost(self._tunnel)) - _MAX_ROWS)


def _is_apart(state: ClockState) -> bool:
    return abs(state.offset_s) - state.error_s >= NOTABLE_OFFSET_S


def _clock(link: HostLink, state: ClockState) -> str:
    steps = f", set {counted(state.n_steps, 'time')}" if state.n_steps else ""
    return f"clock of {link.peer}: {offset_text(state.offset_s, state.error_s, state.drift_ppm)}{steps}"


def _lost(tunnel: Tunnel) -> dict[tuple[str, str], Passed]:
    """Return what is not carried by way and channel: on the way here also what the other ends tell."""
    came, left, told = tunnel.accounts()
    came.add(told)
    found = {("in", name): one for name, one in came.channels.items()}
    return found | {("out", name): one for name, one in left.channels.items()}


def _sum(accounts: Accounts) -> str:
    n_messages = sum(one.passed for one in accounts.channels.values())
    return f"{counted(n_messages, 'message')}, {size_text(sum(one.n_bytes for one in accounts.channels.values()))}"


def _named(news: Mapping[tuple[str, str], int]) -> str:
    return ", ".join(_first_names(news))


def _first_names(news: Mapping[tuple[str, str], int]) -> Iterator[str]:
    """Yield the channels with the most."""
    by_number = sorted(news.items(), key=lambda item: -item[1])
    for (way, name), n in by_number[:_MAX_NAMED]:
        yield f"{shown_name(name)} {way} {n:,}"
    if len(by_number) > _MAX_NAMED:
        yield f"and {counted(len(by_number) - _MAX_NAMED, 'more channel')}"
