"""A share of a core: what is used stays below it, and nothing is left of the group."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from graphnav import UserError
from graphnav.core.machine import CpuQuota, cpu_quota

SPIN = """
import sys, time
sys.stdin.readline()
wall_s, cpu_s = time.monotonic(), time.process_time()
while time.monotonic() < wall_s + 0.3: pass
print((time.process_time() - cpu_s) / (time.monotonic() - wall_s))
"""


@pytest.fixture
def quota() -> CpuQuota:
    """Return a quota of 20 %, where a control group can be made."""
    found = CpuQuota(20)
    try:
        with found:
            pass
    except UserError as error:
        pytest.skip(str(error))
    return found


def test_a_process_gets_its_share_at_most(quota: CpuQuota) -> None:
    with quota, subprocess.Popen([sys.executable, "-c", SPIN], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as spin:
        quota.join(spin.pid)
        told, _ = spin.communicate(b"\n")
    assert float(told) < 0.5


def test_a_process_is_back_where_it_was(quota: CpuQuota) -> None:
    before = Path("/proc/self/cgroup").read_text()
    with quota:
        quota.join()
        assert "graphnav-" in Path("/proc/self/cgroup").read_text()
    assert Path("/proc/self/cgroup").read_text() == before


def test_without_control_groups_it_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mounts = tmp_path / "mounts"
    mounts.write_text("proc /proc proc rw 0 0\n")
    monkeypatch.setattr(cpu_quota, "_MOUNTS", mounts)
    with pytest.raises(UserError) as caught, CpuQuota(25):
        pass
    assert str(caught.value) == (
        "cannot limit the processor to 25 % of a core: no control group can be made: this system has none for "
        "processors\n"
        "  run it as root, or let systemd limit it: systemd-run --user --scope -p CPUQuota=25% COMMAND"
    )
