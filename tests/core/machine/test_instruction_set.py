"""Logs are the same on every machine with AVX2 and FMA: the instruction set is pinned, read back and compared."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import pytest

from graphnav.core.cli import main
from graphnav.core.errors import UserError
from graphnav.core.machine import instruction_set as computed
from graphnav.core.machine import pins
from graphnav.core.machine.instruction_set import PORTABLE

_SAYS = "from graphnav.core.machine.instruction_set import used_instruction_set; print(used_instruction_set())"
_PINNED = ("OPENBLAS_CORETYPE", "OPENCV_CPU_DISABLE", "OPENCV_IPP", "NPY_DISABLE_CPU_FEATURES")

needs_baseline = pytest.mark.skipif(bool(pins.lacking()), reason=pins.lacking())


def said_by(code: str, **environment: str) -> str:
    """Return the output of Python code in a process of its own; the tests' process has pinned the environment."""
    own = {name: value for name, value in os.environ.items() if name not in _PINNED}
    done = subprocess.run(
        [sys.executable, "-c", code], env=own | environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    return done.stdout.strip()


@cache
def native() -> str:
    """Return the instruction set of a process that is not pinned."""
    return said_by(_SAYS, **{pins.OPT_OUT: "0"})


def command(*words: object, **environment: str) -> subprocess.CompletedProcess[str]:
    own = {name: value for name, value in os.environ.items() if name not in _PINNED}
    line = [sys.executable, "-m", "graphnav", *map(str, words)]
    return subprocess.run(line, env=own | environment, capture_output=True, text=True, check=False)


@needs_baseline
@pytest.mark.parametrize(
    "environment",
    [
        {},
        {"OPENBLAS_CORETYPE": "Prescott", "OPENCV_CPU_DISABLE": "AVX2", "OPENCV_IPP": "sse42"},
        {"NPY_ENABLE_CPU_FEATURES": "AVX2"},
        {"NPY_DISABLE_CPU_FEATURES": "AVX2 X86_V3"},
    ],
)
def test_a_process_is_pinned_whatever_its_environment_says(environment: dict[str, str]) -> None:
    assert said_by(f"import graphnav; {_SAYS}", **environment) == PORTABLE


@needs_baseline
@pytest.mark.parametrize("name", _PINNED)
def test_without_any_pin_that_matters_here_a_process_is_not_portable(name: str) -> None:
    matters = {
        "OPENBLAS_CORETYPE": not native().endswith("BLAS Haswell"),
        "OPENCV_CPU_DISABLE": "AVX512" in native().split(", ")[1],
        "OPENCV_IPP": "IPP" in native(),
        "NPY_DISABLE_CPU_FEATURES": "512" in native().split(", ")[0] or "X86_V4" in native(),
    }
    if not matters[name]:
        pytest.skip(f"{name} does not matter on this machine")
    assert said_by(f"import os, graphnav; del os.environ[{name!r}]; {_SAYS}") != PORTABLE


@needs_baseline
def test_numpy_that_was_loaded_before_is_recorded_as_it_is() -> None:
    assert said_by(f"import numpy, cv2, graphnav; {_SAYS}") == native()


@needs_baseline
@pytest.mark.long
def test_logs_do_not_depend_on_the_environment(tmp_path: Path) -> None:
    logs = []
    for place, environment in enumerate([{}, {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": "AVX2"}]):
        folder = tmp_path / str(place)
        words = ("run", "pillars", "--until", "0.4", "--no-tap", "--no-pictures", "-o", folder)
        done = command(*words, **environment)
        assert done.returncode == 0, done.stderr
        logs.append((folder / "run.lcmlog").read_bytes())
    assert logs[0] == logs[1]


@needs_baseline
@pytest.mark.long
@pytest.mark.usefixtures("study_workers")
def test_a_study_does_not_mix_instruction_sets(tmp_path: Path) -> None:
    words = ["ablate", "corridor_ccw", "--vary", "plane=plane.ica", "--gallery", "0", "-o", str(tmp_path / "s")]
    words += ["--set", "run.until_s=0.3"]
    assert main([*words, "--seeds", "0:1"]) == 0
    if native() == PORTABLE:
        pytest.skip("this machine has nothing beyond AVX2 and FMA")
    other = command(*words, "--seeds", "0:2", "--no-portable")
    assert other.returncode == 2
    assert f"another instruction set: {PORTABLE}, now {native()}" in " ".join(other.stderr.split())
    assert "without --no-portable" in other.stderr
    assert main([*words, "--seeds", "0:2"]) == 0


@needs_baseline
@pytest.mark.long
def test_a_study_from_python_is_portable_although_numpy_was_loaded_before(tmp_path: Path) -> None:
    folder = str(tmp_path / "s")
    code = (
        "import numpy, cv2, json, graphnav\n"
        "options = {'vary': {'plane': ['plane.ica']}, 'seeds': [0], 'set': {'run.until_s': 0.3}, 'gallery': 0}\n"
        f"graphnav.ablate('corridor_ccw', folder={folder!r}, **options)\n"
        f"print(json.load(open({folder!r} + '/plan.json'))['versions']['instruction set'])"
    )
    assert said_by(code).splitlines()[-1] == PORTABLE


def test_a_cpu_without_the_baseline_is_refused_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    cpu = tmp_path / "cpuinfo"
    cpu.write_text("processor : 0\nmodel name\t: Old CPU 3000\nflags\t\t: sse sse2 fma\n")
    monkeypatch.setattr(pins, "_CPU_INFO", cpu)
    monkeypatch.setattr("os.uname", lambda: SimpleNamespace(machine="x86_64"))
    computed.used_instruction_set.cache_clear()
    monkeypatch.setattr(computed, "used_instruction_set", lambda: "numpy SSE")
    with pytest.raises(UserError, match=r"this CPU \(Old CPU 3000\) has no avx2, f16c, bmi1, bmi2, movbe, abm, which"):
        computed.require_portable()
    monkeypatch.setattr("os.uname", lambda: SimpleNamespace(machine="aarch64"))
    with pytest.raises(UserError, match="not of x86-64 but aarch64"):
        computed.require_portable()


def test_nothing_is_pinned_where_it_cannot_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pins, "_CPU_INFO", tmp_path / "nothing")
    monkeypatch.setattr(pins, "_LIBRARIES", ())
    before = dict(os.environ)
    pins.pin()
    assert dict(os.environ) == before


@needs_baseline
def test_what_was_in_the_environment_is_restored(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pins, "_LIBRARIES", ())
    monkeypatch.setattr(pins, "_replaced", {})
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Zen")
    monkeypatch.setenv("NPY_ENABLE_CPU_FEATURES", "AVX2")
    monkeypatch.delenv("OPENCV_IPP", raising=False)
    monkeypatch.setenv(pins.OPT_OUT, "1")
    before = dict(os.environ)
    pins.pin()
    assert os.environ["OPENBLAS_CORETYPE"] == "Haswell"
    assert "NPY_ENABLE_CPU_FEATURES" not in os.environ
    pins.unpin()
    assert dict(os.environ) == before | {pins.OPT_OUT: "0"}


@needs_baseline
def test_a_graph_that_asks_for_it_runs_only_portably(tmp_path: Path) -> None:
    words = ("run", "corridor_ccw", "--until", "0.2", "--no-tap", "--no-pictures", "--set", "run.portable=true", "-o")
    assert command(*words, tmp_path / "a").returncode == 0
    refused = command(*words, tmp_path / "b", **{pins.OPT_OUT: "0"})
    if native() != PORTABLE:
        assert refused.returncode == 2
        assert "a portable run needs" in refused.stderr
        assert not (tmp_path / "b").exists()
