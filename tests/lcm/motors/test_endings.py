"""However a program that drives ends, its robot is stopped."""

from __future__ import annotations

import os
import signal
import subprocess
import time

import pytest

from .conftest import Start
from .listening import Listener, is_gone, wait_until


def last_words(process: subprocess.Popen[str]) -> tuple[int, float]:
    """Return the id of the sending process and the time right before the end."""
    assert process.stdout is not None
    return int(process.stdout.readline()), float(process.stdout.readline())


def stopped(listener: Listener, child: int, end_s: float) -> None:
    """Check what is sent around the end of a program, and that its process is gone."""
    wait_until(lambda: is_gone(child))
    listener.wait_for_stops()
    commands, stops = listener.commands(), listener.stops()
    assert commands
    assert commands[-1].at_s < stops[0].at_s
    for values in ([heard.seq for heard in listener.heard], [heard.utime for heard in listener.heard]):
        assert values == sorted(set(values))
    assert stops[-1].at_s - stops[0].at_s > 0.9
    print(f"first stop {1e3 * (stops[0].at_s - end_s):.1f} ms after the end, {len(stops)} stops")
    assert stops[0].at_s - end_s < 3.0


@pytest.mark.parametrize(
    "ending",
    ["return", "raise", "sys.exit", "os._exit", "abort", "segfault", "truncated frame", "exit in a thread", "close"],
)
def test_a_program_that_ends_by_itself(ending: str, drive: Start, listener: Listener) -> None:
    child, end_s = last_words(drive(ending))
    stopped(listener, child, end_s)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGSEGV])
def test_a_program_that_a_signal_ends(number: signal.Signals, drive: Start, listener: Listener) -> None:
    process = drive("drive on")
    assert process.stdout is not None
    child = int(process.stdout.readline())
    listener.wait_for(lambda heard: len(heard) >= 5)
    end_s = time.monotonic()
    process.send_signal(number)
    assert process.wait() != 0
    stopped(listener, child, end_s)


def test_a_program_that_leaves_a_process_behind_that_holds_the_pipe(drive: Start, listener: Listener) -> None:
    if not hasattr(os, "pidfd_open"):
        pytest.skip("this kernel cannot tell of the end of another process")
    process = drive("fork")
    child, end_s = last_words(process)
    stopped(listener, child, end_s)


def test_signals_of_the_terminal_do_not_reach_the_process(drive: Start, listener: Listener) -> None:
    process = drive("drive on")
    assert process.stdout is not None
    child = int(process.stdout.readline())
    assert os.getsid(child) == child
    assert os.getpgid(child) != os.getpgid(process.pid)


def test_a_shell_that_reads_the_output_does_not_wait_for_the_stops(drive: Start, listener: Listener) -> None:
    process = drive("os._exit")
    assert process.stdout is not None
    child = int(process.stdout.readline())
    process.stdout.read()
    assert not is_gone(child)
    wait_until(lambda: is_gone(child))


@pytest.mark.parametrize("ending", ["be silent", "hold the GIL", "backtrack"])
def test_a_program_that_hangs(ending: str, drive: Start, listener: Listener) -> None:
    process = drive(ending, 0.5)
    child, end_s = last_words(process)
    listener.wait_for(lambda heard: heard[-1].is_stop and heard[-1].at_s > end_s + 2.0)
    assert process.poll() is None
    last_s = listener.commands()[-1].at_s
    stops = [heard for heard in listener.stops() if heard.at_s > last_s]
    assert len(stops) >= 20
    print(f"first stop {1e3 * (stops[0].at_s - last_s):.1f} ms after the last command, at a limit of 500 ms")
    assert 0.4 < stops[0].at_s - last_s < 3.0
    process.kill()
    wait_until(lambda: is_gone(child))


def test_a_program_that_is_suspended_and_goes_on(drive: Start, listener: Listener) -> None:
    process = drive("drive on", 0.2)
    listener.wait_for(lambda heard: len(heard) >= 5)
    process.send_signal(signal.SIGSTOP)
    listener.wait_for_stops()
    n_commands = len(listener.commands())
    process.send_signal(signal.SIGCONT)
    listener.wait_for(lambda _: len(listener.commands()) >= n_commands + 5)
    seqs = [heard.seq for heard in listener.heard]
    assert seqs == sorted(set(seqs))
