"""The full-screen spy, record and view beside each other on one group, and what they say of it."""

from __future__ import annotations

import json
import math
import re
import subprocess
import tempfile
import time
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from testbed.drives import GRAPHNAV
from testbed.processes import PATIENCE_S, await_listeners
from testbed.terminal import SpyTerminal
from websockets.sync.client import connect
from websockets.typing import Origin

from .sane_sender import CHANNEL, RATE_HZ

SPY, RECORD, VIEW, JSON = "spy", "record", "view", "spy --json"
_LOOK_S = 2.0
_RATE_S = 11.0
"""Rates are those of the last 10 s."""
_WIDE, _HIGH = 200, 50


@dataclass(frozen=True)
class Counted:
    """Counts that a program reports of all messages; ``undecodable``: None if it does not decode."""

    messages: int
    undecodable: int | None
    dropped_packets: int


class Watchers:
    """The three programs, while entered; the spy in a terminal of 80x24."""

    def __init__(self, url: str, port: int) -> None:
        self._url, self._port = url, port
        self._open = ExitStack()
        self._page = ""
        self.pids: dict[str, int] = {}

    def dead(self) -> list[str]:
        """Return which programs have ended."""
        ended = {
            SPY: not self._spy.is_alive,
            RECORD: self._record.poll() is not None,
            VIEW: self._view.poll() is not None,
        }
        return [name for name, has_ended in ended.items() if has_ended]

    def top_of_screen(self) -> list[str]:
        """Return the first lines of the spy's screen, and so of its table."""
        self._spy.press("Home")
        time.sleep(_LOOK_S)
        return self._spy.screen()[:9]

    def sane_rates_hz(self) -> dict[str, float | None]:
        """Wait until the sane channel alone is left; return what each program tells of its rate, a new one as well."""
        self._await_quiet()
        self._filter_sane()
        time.sleep(_RATE_S)
        sane = next(channel for channel in self._state()["channels"] if channel["name"] == CHANNEL)
        cell = self._spy.cells(CHANNEL).get("rate", "").removesuffix(" Hz")
        command = [str(GRAPHNAV), "spy", self._url, "--json", "--for", "6"]
        new = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        return {
            VIEW: sane["rate_hz"],
            SPY: float(cell) if cell not in {"", "-"} else None,
            JSON: new["channels"][CHANNEL]["rate_hz"],
        }

    def counted(self) -> dict[str, Counted]:
        """Return what each program has counted; ends record, which says it then."""
        time.sleep(_LOOK_S)
        state, heading = self._state(), self._spy.screen()[0] + "  "
        self._record.terminate()
        text = self._record.communicate(timeout=PATIENCE_S)[0]
        line = next(line for line in reversed(text.splitlines()) if " messages, " in line)
        unnamed = _number(r"([\d,]+) messages? on a channel without a name", line)
        return {
            VIEW: Counted(state["messages"], state["undecodable"], state["dropped_packets"]),
            SPY: Counted(
                _number(r"(\d+) messages  ", heading),
                _number(r"(\d+) undecodable", heading),
                _number(r"(\d+) packets? dropped", heading),
            ),
            RECORD: Counted(
                _number(r"^([\d,]+) messages, ", line) + unnamed, None, _number(r"([\d,]+) packets? dropped", line)
            ),
        }

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            self._record = self._start(stack, "record", self._url, "-o", str(Path(folder) / "hostile.lcmlog"))
            self._view = self._start(stack, "view", self._url, "--port", "0")
            self._spy = stack.enter_context(SpyTerminal(self._url, 80, 24))
            assert self._view.stdout is not None
            found = re.search(r"http://[\d.]+:\d+", self._view.stdout.readline())
            assert found is not None
            self._page = found[0]
            await_listeners(self._port, 3, PATIENCE_S)
            self.pids = {SPY: self._spy.pid, RECORD: self._record.pid, VIEW: self._view.pid}
            self._open = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._open.close()

    def _start(self, stack: ExitStack, *words: str) -> subprocess.Popen[str]:
        process = subprocess.Popen([str(GRAPHNAV), *words], stdout=subprocess.PIPE, text=True)
        stack.enter_context(process)
        stack.callback(process.terminate)
        return process

    def _state(self) -> dict[str, Any]:
        """Return what the page's server tells a page that has just been opened."""
        address = f"{self._page.replace('http', 'ws')}/updates"
        with connect(address, origin=Origin(self._page), max_size=None) as socket:
            socket.recv(PATIENCE_S)
            state: dict[str, Any] = json.loads(socket.recv(PATIENCE_S))["state"]
        return state

    def _await_quiet(self) -> None:
        """Wait until only the sane channel is still being counted."""
        end_s = time.monotonic() + PATIENCE_S
        before, newest = -math.inf, float(self._state()["messages"])
        while newest - before > 2 * RATE_HZ * _LOOK_S and time.monotonic() < end_s:
            time.sleep(_LOOK_S)
            before, newest = newest, float(self._state()["messages"])

    def _filter_sane(self) -> None:
        """Let the spy show the sane channel alone, and give it room for all of heading and table."""
        self._spy.press("/")
        self._spy.wait_for(lambda lines: any("part of a channel" in line for line in lines))
        self._spy.press(CHANNEL, "Enter")
        self._spy.resize(_WIDE, _HIGH)
        self._spy.wait_for(lambda lines: any("transport ms" in line for line in lines))


def _number(pattern: str, text: str) -> int:
    """Return the number that a pattern finds, 0 where it does not."""
    found = re.search(pattern, text)
    return int(found[1].replace(",", "")) if found else 0
