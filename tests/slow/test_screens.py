"""The spy beside a run, as a user has them: two terminals, several kinds of them, and what stands on the screen."""

from __future__ import annotations

import shlex
import subprocess
import time
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import lcm
import pytest
from testbed.drives import GRAPHNAV
from testbed.processes import await_file, end, group_url
from testbed.terminal import HAS_TMUX, Terminal

from graphnav import Recording
from graphnav.core.run_folder import RunFolder
from tests.targets import Targets

from .screen_reading import has_picture, screen_picture, shown_rates

_FIRST_S, _SECOND_S = 40, 20
"""How long the two runs last."""
_WINDOW_S = 10.0
"""The spy's rates are those of the last 10 s."""
_WATCHED_S = 13.0
_MAX_ERROR = 0.02
_PICTURES = ("robot.image", "flow.flow", "plane.plane")
_PLOTTED, _FIELDS = "control.twist", ("v_mps", "omega_radps")


@dataclass(frozen=True)
class Look:
    """A kind of terminal: columns and rows, and its environment."""

    size: tuple[int, int]
    environment: Mapping[str, str]


_LOOKS = {
    "80x24": Look((80, 24), {"TERM": "tmux-256color"}),
    "200x50": Look((200, 50), {"TERM": "tmux-256color"}),
    "80x24-no-colour": Look((80, 24), {"TERM": "tmux-256color", "NO_COLOR": "1"}),
    "80x24-vt100": Look((80, 24), {"TERM": "vt100"}),
}


@pytest.mark.skipif(not HAS_TMUX, reason="tmux is not installed")
@pytest.mark.parametrize("name", _LOOKS)
def test_screens(targets: Targets, seeds: range, tmp_path_factory: pytest.TempPathFactory, name: str) -> None:
    """Watch two runs one after the other in a kind of terminal; print rates and where the captures are."""
    folder = tmp_path_factory.mktemp(f"screens-{name}")
    url = group_url(221 + list(_LOOKS).index(name))
    with closing(_Watched(folder, _LOOKS[name], url)) as watched:
        good, numbers = watched.look(seeds[:2])
    targets.check(f"{name}: {numbers}", good=good)
    targets.say(f"look at {folder}")


class _Watched:
    """A spy in one terminal, runs in another one, and lcm-logger, which hears what the spy hears."""

    def __init__(self, folder: Path, look: Look, url: str) -> None:
        self._folder, self._look, self._url = folder, look, url
        self._spy = Terminal(folder / "spy.tmux")
        self._runs: list[Terminal] = []
        self._heard = folder / "heard.lcmlog"
        command = [str(Path(lcm.LCM_BIN_DIR) / "lcm-logger"), "--quiet", "--flush-interval", "100", "--lcm-url"]
        command += [f"{url}&recv_buf_size=2097152", str(self._heard)]
        self._logger = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def close(self) -> None:
        """End everything."""
        for terminal in (self._spy, *self._runs):
            terminal.close()
        end(self._logger)

    def look(self, seeds: Sequence[int]) -> tuple[bool, str]:
        """Watch two runs; return whether all was as it should be, and what was measured."""
        variables = " ".join(f"{name}={value}" for name, value in self._look.environment.items())
        command = f"env {variables} {shlex.quote(str(GRAPHNAV))} spy; echo ended with $?; sleep 3600"
        self._spy.start(f"env LCM_DEFAULT_URL={shlex.quote(self._url)} sh -c {shlex.quote(command)}", self._look.size)
        self._spy.wait_for(lambda shown: "no publisher" in shown)
        self._keep("0-no-publisher")
        self._start_run("first", seeds[0], _FIRST_S)
        errors = self._rates_when_steady("1-table")
        for place, channel in enumerate(_PICTURES, start=2):
            self._open(channel)
            self._spy.wait_for(has_picture)
            time.sleep(1.0)
            self._keep(f"{place}-{channel}")
            self._go_back()
        self._open(_PLOTTED)
        self._spy.wait_for(lambda shown: all(f"• {field} " in shown for field in _FIELDS))
        self._keep("5-plot")
        self._spy.wait_for(lambda shown: "stale for" in shown)
        self._keep("6-stale")
        self._go_back()
        self._spy.wait_for(lambda shown: not any(shown_rates(shown).values()))
        self._keep("7-table-of-a-finished-run")
        self._start_run("second", seeds[1], _SECOND_S)
        errors_again = self._rates_when_steady("8-table-of-the-next-run")
        self._spy.press("q")
        self._spy.wait_for(lambda shown: "ended with 0" in shown)
        return self._judged({"first": errors, "second": errors_again})

    def _start_run(self, name: str, seed: int, until_s: float) -> None:
        terminal = Terminal(self._folder / f"{name}.tmux")
        self._runs.append(terminal)
        words = ["run", "corridor_ccw", "--pace", "1", "--seed", str(seed), "--until", str(until_s), "--no-pictures"]
        command = shlex.join([str(GRAPHNAV), *words, "-o", str(self._folder / name)])
        shell = f"LCM_DEFAULT_URL={shlex.quote(self._url)} {command}; sleep 3600"
        terminal.start(f"sh -c {shlex.quote(shell)}", (100, 24))
        await_file(self._folder / name / RunFolder.LOG)

    def _rates_when_steady(self, name: str) -> dict[str, tuple[float | None, float | None]]:
        """Return, for each channel, the rate on the screen and that of the stamps that lcm-logger heard in 10 s."""
        self._spy.wait_for(lambda shown: bool(shown_rates(shown).get(_PLOTTED)))
        time.sleep(_WATCHED_S)
        begin_us = (time.time() - _WINDOW_S) * 1e6
        shown = shown_rates(self._keep(name))
        heard: dict[str, list[int]] = {}
        with Recording(self._heard) as recording:
            for head in recording.heads():
                if head.logged_us >= begin_us:
                    heard.setdefault(head.channel, []).append(head.utime)
        return {channel: (rate, _rate(heard.get(channel, []))) for channel, rate in shown.items()}

    def _open(self, channel: str) -> None:
        """Filter for a channel and open it, at a person's pace."""
        self._spy.press("/")
        self._spy.wait_for(lambda shown: "part of a channel" in shown)
        self._spy.press(channel)
        self._spy.wait_for(lambda shown: channel in shown_rates(shown) and "robot.goal" not in shown_rates(shown))
        self._spy.press("Enter")
        self._spy.wait_for(lambda shown: "⏎ open" in shown)
        self._spy.press("Enter")
        self._spy.wait_for(lambda shown: "Esc back" in shown)

    def _go_back(self) -> None:
        self._spy.press("Escape")
        self._spy.wait_for(lambda shown: "⏎ open" in shown)
        self._spy.press("Escape")
        self._spy.wait_for(lambda shown: "robot.goal" in shown_rates(shown))

    def _keep(self, name: str) -> str:
        """Save what stands on the screen, as text and as a picture; return the text."""
        shown, coloured = self._spy.screen(), self._spy.screen("-e")
        (self._folder / f"{name}.txt").write_text(shown, encoding="utf-8")
        screen_picture(coloured, self._look.size).save(self._folder / f"{name}.png")
        return shown

    def _judged(self, runs: Mapping[str, Mapping[str, tuple[float | None, float | None]]]) -> tuple[bool, str]:
        """Compare the rates on the screen with those of each run's own log, else with what lcm-logger heard."""
        said, good = [], True
        for name, rates in runs.items():
            with Recording(self._folder / name / RunFolder.LOG) as recording:
                logged = {channel: _rate(recording.utimes(channel)) for channel in recording.channels}
            missing = logged.keys() - rates.keys()
            by_log = [_error(rates[channel][0], rate) for channel, rate in logged.items() if rate and not missing]
            by_ear = {
                channel: _error(shown, heard)
                for channel, (shown, heard) in rates.items()
                if shown is not None or logged.get(channel, heard)
            }
            good &= not missing and max((*by_log, *by_ear.values()), default=1.0) <= _MAX_ERROR
            worst = max(by_ear, key=lambda channel: by_ear[channel], default="none")
            said.append(
                f"the {name} run: {len(logged) - len(missing)} of {len(logged)} channels are shown; rates differ "
                f"by {max(by_log, default=1.0):.2%} at most from the log's stamps ({len(by_log)} channels), by "
                f"{max(by_ear.values(), default=1.0):.2%} from what lcm-logger heard ({len(by_ear)} channels; {worst})"
            )
        return good, "; ".join(said)


def _rate(utimes: Sequence[int]) -> float | None:
    """Return the rate of stamps in microseconds; None where there is but one, repeated or not."""
    span_us = utimes[-1] - utimes[0] if utimes else 0
    return 1e6 * (len(utimes) - 1) / span_us if span_us > 0 else None


def _error(shown: float | None, real: float | None) -> float:
    return abs(shown / real - 1) if shown and real else 1.0
