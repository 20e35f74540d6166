"""Sums of messages that a tunnel has carried and dropped, for the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from graphnav.core.cli import counted
from graphnav.core.errors import shown_name
from graphnav.core.runner import size_text
from graphnav.core.tables import Table
from graphnav.processes.host_link import Refusal
from graphnav.processes.tunnel.outbox import Accounts, Passed
from graphnav.processes.tunnel.tunnel import Tunnel

_MAX_NAMED = 5
_MAX_ROWS = 100
_LOSSES = {"dropped": "dropped", "thinned": "above their rate", "held": "on motor channels that are not named"}


class Report:
    """Tells what has changed since it was asked last."""

    def __init__(self, tunnel: Tunnel) -> None:
        self._tunnel = tunnel
        self._lost: dict[tuple[str, str], Passed] = {}
        self._refused: dict[Refusal, int] = {}
        self._packets = self._overruns = 0

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
