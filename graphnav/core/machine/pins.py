"""Pin numpy, OpenCV and OpenBLAS to one instruction set, so that logs are the same on every machine that has it.

Each library chooses its code by the CPU: sums in registers of another length are rounded otherwise. Environment
variables choose for it, if they are set before the library is loaded.
"""

from __future__ import annotations

import os
import re
import sys
from importlib.util import find_spec

BASELINE = ("avx2", "fma", "f16c", "bmi1", "bmi2", "movbe", "abm")
"""Flags of a CPU that has the pinned instruction set, as Linux spells them: x86-64-v3, of Intel from 2013, AMD 2015."""
OPT_OUT = "GRAPHNAV_PORTABLE"
"""The environment variable that, set to 0, lets the libraries choose."""
_CPU_INFO = "/proc/cpuinfo"
_MAX_CPU_INFO = 16_384
_LIBRARIES = ("numpy", "cv2")
_CHOOSING = ("NPY_ENABLE_CPU_FEATURES", "OPENCV_CPU_DISABLE")
"""Variables that choose code too: unset where no pin sets them. Numpy refuses what to use beside what not to use."""

_replaced: dict[str, str | None] = {}
"""The values that the pins have replaced in the environment of this process."""


def pins() -> dict[str, str]:
    """Return the environment variables that pin the libraries."""
    found = {
        "OPENBLAS_CORETYPE": "Haswell",
        "OPENCV_IPP": "disabled",
        "OPENCV_LOG_LEVEL": os.environ.get("OPENCV_LOG_LEVEL", "ERROR"),  # it warns that IPP is disabled
        "NPY_DISABLE_CPU_FEATURES": " ".join(_beyond_baseline()),
    }
    if "avx512bw" in _cpu()[1]:  # OpenCV complains of what the CPU does not have
        found["OPENCV_CPU_DISABLE"] = "AVX512-SKX"
    return found


def pin() -> None:
    """Set the variables for what this process loads and starts, unless it is too late, not possible or not wanted."""
    if os.environ.get(OPT_OUT) != "0" and not any(name in sys.modules for name in _LIBRARIES) and not lacking():
        wanted = pins()
        unwanted = [name for name in _CHOOSING if name not in wanted]
        _replaced.update({name: os.environ.get(name) for name in (*wanted, *unwanted)})
        os.environ.update(wanted)
        for name in unwanted:
            os.environ.pop(name, None)


def unpin() -> None:
    """Restore the environment, also for the processes that this one starts."""
    os.environ[OPT_OUT] = "0"
    for name, value in _replaced.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
    _replaced.clear()


def lacking() -> str:
    """Return why this CPU cannot run the pinned instruction set, empty if it can; only Linux tells what it has."""
    if sys.platform != "linux":
        return "the instruction set is the same for all machines on Linux only"
    if (machine := os.uname().machine) != "x86_64":
        return f"this CPU is not of x86-64 but {machine or 'of an unknown kind'}"
    name, flags = _cpu()
    missing = [flag for flag in BASELINE if flag not in flags]
    return f"this CPU ({name}) has no {', '.join(missing)}" if missing else ""


def _cpu() -> tuple[str, frozenset[str]]:
    """Return the model and the flags of the first processor."""
    try:
        with open(_CPU_INFO, encoding="utf-8", errors="replace") as file:
            text = file.read(_MAX_CPU_INFO)
    except OSError:
        return "unknown", frozenset()
    values = dict(re.findall(r"^(model name|flags)\s*:\s*(.*)$", text, re.MULTILINE)[:2])
    return values.get("model name", "unknown"), frozenset(values.get("flags", "").split())


def _beyond_baseline() -> tuple[str, ...]:
    """Return the features beyond the baseline for which the installed numpy has code, by its names."""
    version = _numpy_version()
    if version >= (2, 4):
        return "X86_V4", "AVX512_ICL", "AVX512_SPR"
    older = "AVX512F", "AVX512CD", "AVX512_SKX", "AVX512_CLX", "AVX512_CNL", "AVX512_ICL"
    return older if version < (2, 3) else (*older, "AVX512_SPR")


def _numpy_version() -> tuple[int, int]:
    """Return the first two numbers of the version of numpy without loading it."""
    spec = find_spec("numpy")
    assert spec is not None, "numpy is a dependency"
    assert spec.origin is not None, "numpy is a package with a file"
    with open(os.path.join(os.path.dirname(spec.origin), "version.py"), encoding="utf-8") as file:
        text = file.read()
    found = re.search(r"""^(?:short_)?version\s*=\s*["'](\d+)\.(\d+)""", text, re.MULTILINE)
    return (int(found[1]), int(found[2])) if found else (0, 0)
