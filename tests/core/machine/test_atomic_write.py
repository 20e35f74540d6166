"""A file is the former one or the new one, whatever happens while it is written."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from graphnav.core.errors import GraphnavError
from graphnav.core.machine.files import write_atomically

DiskOf = Callable[[int], AbstractContextManager[None]]

KILLED = """
import resource, signal, sys
from pathlib import Path
from graphnav.core.machine.files import write_atomically
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
sys.dont_write_bytecode = True
resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))
signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
write_atomically(Path(sys.argv[1]), 100_000 * "x")
"""
"""The kernel kills the process when half of the file is written."""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Return a file that is there."""
    path = tmp_path / "table.md"
    write_atomically(path, "former\n")
    return path


def test_the_new_one_takes_the_place_of_the_former(path: Path) -> None:
    write_atomically(path, "größer\r\n" * 1000)
    assert path.read_bytes() == ("größer\r\n" * 1000).encode()
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize("n_bytes", [0, 1, 99_999])
def test_a_full_disk_is_said_and_leaves_the_former(disk_of: DiskOf, path: Path, n_bytes: int) -> None:
    with disk_of(n_bytes), pytest.raises(GraphnavError, match=f"^cannot write {path}: File too large$"):
        write_atomically(path, 100_000 * "x")
    assert path.read_text() == "former\n"
    assert list(path.parent.iterdir()) == [path], "and nothing of the new one"


def test_a_process_that_is_killed_leaves_the_former(path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", KILLED, str(path)], check=False)
    assert done.returncode == -signal.SIGXFSZ
    assert path.read_text() == "former\n"


def test_a_folder_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(GraphnavError, match=r"cannot write .*: No such file or directory"):
        write_atomically(tmp_path / "no" / "table.md", "")
