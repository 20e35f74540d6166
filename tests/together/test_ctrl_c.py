"""Ctrl-C, SIGTERM and SIGHUP are not lost where exceptions are, and give no traceback."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from graphnav.core.cli import main
from graphnav.core.parameters import command
from graphnav.develop.commands import doctor

IN_AN_IMPORT = """
import os, runpy, signal, sys

number = int(sys.argv.pop())

class Sender:
    def find_spec(self, name, path=None, target=None):
        if name == "matplotlib.ft2font":
            try:
                os.kill(os.getpid(), number)
            except KeyboardInterrupt:
                raise ImportError(name) from None  # as compiled modules do

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, Sender())
sys.argv = ["graphnav", "run", "corridor_ccw", "--until", "0.5", "--no-tap", "-o", "out"]
runpy.run_module("graphnav", run_name="__main__")
"""
IN_A_CALLBACK = """
import signal, time, weakref
from graphnav.core.interrupts import CtrlC, ctrl_c_not_lost, raise_ctrl_c

class Kept: ...

signal.signal(NUMBER, raise_ctrl_c)
kept = Kept()
watch = weakref.ref(kept, lambda _: signal.raise_signal(NUMBER))
with ctrl_c_not_lost():
    try:
        del kept
        time.sleep(60)
    except CtrlC:
        print("raised")
"""
IN_A_HANGING_IMPORT = """
import signal, sys, threading, time
from pathlib import Path
from graphnav.core.interrupts import CtrlC, raise_ctrl_c

signal.signal(signal.SIGTERM, raise_ctrl_c)
Path("hanging.py").write_text("import signal, time; signal.raise_signal(signal.SIGTERM); time.sleep(60)")
sys.path.insert(0, "")
try:
    import hanging
except CtrlC:
    print("raised")
"""
IN_A_CONSTRUCTOR = """
import os, signal
from graphnav.core.interrupts import CtrlC, ctrl_c_later, raise_ctrl_c

signal.signal(NUMBER, raise_ctrl_c)
try:
    with ctrl_c_later():
        os.kill(os.getpid(), NUMBER)
        print("made")
    print("lost")
except CtrlC:
    print("raised")
"""
SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]


def python(code: str, folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run a program."""
    command = [sys.executable, "-c", code, *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, cwd=folder)


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_in_an_import_is_obeyed_after_it(tmp_path: Path, number: int) -> None:
    done = python(IN_AN_IMPORT, tmp_path, str(int(number)))
    said = "some pictures were not drawn; to draw them, run: graphnav figure out\nstopped\n"
    assert (done.returncode, done.stderr) == (130, said)


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_in_a_callback_is_obeyed_after_it(tmp_path: Path, number: int) -> None:
    done = python(IN_A_CALLBACK.replace("NUMBER", str(int(number))), tmp_path)
    assert (done.stdout, done.stderr) == ("raised\n", "")


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_waits_for_the_end_of_a_constructor(tmp_path: Path, number: int) -> None:
    done = python(IN_A_CONSTRUCTOR.replace("NUMBER", str(int(number))), tmp_path)
    assert (done.stdout, done.stderr) == ("made\nraised\n", "")


def test_a_signal_ends_an_import_that_hangs(tmp_path: Path) -> None:
    done = python(IN_A_HANGING_IMPORT, tmp_path)
    assert (done.stdout, done.stderr) == ("raised\n", "")


def test_an_error_that_ctrl_c_causes_is_not_shown(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stopped(_: object) -> int:
        try:
            raise KeyboardInterrupt
        finally:
            raise RuntimeError("not closed")

    monkeypatch.setattr(doctor, "main", command()(stopped))
    assert main(["doctor"]) == 130
    assert capsys.readouterr().err == "stopped\n"
