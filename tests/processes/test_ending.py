"""No process is left by a run, whatever ends it."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphnav.core.run_folder import RunFolder
from tests.processes.commands import Command
from tests.processes.conftest import is_alive, wait_until

WITHIN_S = 2.0
"""So soon is every process of a run gone whose supervisor was killed."""


@pytest.fixture
def command(tmp_path: Path) -> Iterator[list[Command]]:
    """Return a list for a command, whose processes are killed at the end."""
    given: list[Command] = []
    yield given
    for one in given:
        one.process.kill()
        one.process.communicate()
        for pid in one.others:
            os.kill(pid, signal.SIGKILL)


def test_a_supervisor_that_is_killed_leaves_nothing_not_even_what_left_its_session(
    command: list[Command], tmp_path: Path
) -> None:
    started = tmp_path / "started"
    command.append(Command(tmp_path, f"{{at: 3, what: start, file: {started}}}"))
    wait_until(lambda: started.exists() and bool(started.read_text()))
    grandchildren = list(map(int, started.read_text().split()))
    assert all(map(is_alive, grandchildren))
    command[0].kill()
    assert command[0].gone_after_s() < WITHIN_S
    assert not any(map(is_alive, grandchildren))


def test_a_supervisor_that_is_killed_while_a_child_imports_leaves_nothing(
    command: list[Command], tmp_path: Path
) -> None:
    command.append(Command(tmp_path, "{}"))
    wait_until(lambda: len(command[0].others) >= 2)
    command[0].kill()
    assert command[0].gone_after_s() < WITHIN_S


def test_a_warden_that_is_killed_is_replaced(command: list[Command], tmp_path: Path) -> None:
    started = tmp_path / "started"
    command.append(Command(tmp_path, f"{{at: 3, what: start, file: {started}}}"))
    wait_until(lambda: started.exists() and bool(started.read_text()))
    first = command[0].warden
    assert first is not None
    os.kill(first, signal.SIGKILL)
    wait_until(lambda: command[0].warden not in {None, first})
    assert command[0].process.poll() is None
    command[0].kill()
    assert command[0].gone_after_s() < WITHIN_S


def test_ctrl_c_ends_a_step_that_hangs_and_all_processes(command: list[Command], tmp_path: Path) -> None:
    hanging = tmp_path / "hanging"
    command.append(Command(tmp_path, f"{{at: 3, what: hang, file: {hanging}}}"))
    wait_until(lambda: hanging.exists() and bool(hanging.read_text()))
    command[0].process.send_signal(signal.SIGINT)
    printed, _ = command[0].process.communicate(timeout=60)
    assert command[0].process.returncode == 130, printed
    assert "Traceback" not in printed
    assert not command[0].others
    assert '"outcome": "stopped"' in (command[0].folder / RunFolder.SUMMARY).read_text()
    assert '"second": {\n   "steps"' in (command[0].folder / RunFolder.SUMMARY).read_text()


def test_ctrl_c_within_the_delay_of_a_restart_starts_nothing(command: list[Command], tmp_path: Path) -> None:
    command.append(Command(tmp_path, "{at: 3, what: exit}", "restart: on_failure, restart_delay_s: 0.3"))
    output = command[0].process.stdout
    assert output is not None
    lines: list[str] = []
    while "it is started again" not in (lines[-1] if lines else ""):
        lines.append(output.readline())
        assert lines[-1], lines
    command[0].process.send_signal(signal.SIGINT)
    printed, _ = command[0].process.communicate(timeout=60)
    assert command[0].process.returncode == 130, printed
    assert "started again" not in printed
    assert not command[0].others
