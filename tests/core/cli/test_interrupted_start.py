"""Ctrl-C while a command starts, in whatever import it comes, ends the process with its status and no traceback."""

from __future__ import annotations

import subprocess
import sys

import pytest

START = """
import os, runpy, signal, sys

module = sys.argv.pop()

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == module:
            try:
                os.kill(os.getpid(), signal.SIGINT)
                os.kill(os.getpid(), signal.SIGINT)
            except KeyboardInterrupt:
                raise ImportError(name) from None  # as compiled modules do

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, Interrupt())
sys.argv = ["graphnav", "check", "corridor_ccw"]
runpy.run_module("graphnav", run_name="__main__")
"""


@pytest.mark.parametrize("module", ["argparse", "graphnav.core.cli.check", "pluggy", "yaml", "cv2"])
def test_an_interrupt_in_an_import_ends_the_process(module: str) -> None:
    code = [sys.executable, "-c", START, module]
    done = subprocess.run(code, capture_output=True, text=True, timeout=300, check=False)
    assert (done.returncode, done.stderr) == (130, "stopped\n")
