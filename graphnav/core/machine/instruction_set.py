"""The instruction set that this process computes with, as the loaded libraries say."""

from __future__ import annotations

import importlib
import os
from functools import cache

import cv2
import numpy as np
from threadpoolctl import threadpool_info

from graphnav.core.errors import UserError
from graphnav.core.machine.pins import OPT_OUT, lacking

PORTABLE = "AVX2 and FMA"
"""The pinned instruction set: logs are the same on all CPUs that have it."""


@cache
def used_instruction_set() -> str:
    """Return `PORTABLE`, or what numpy, OpenCV and BLAS have chosen by the CPU."""
    numpy, opencv, blas = _numpy(), _opencv(), _blas()
    beyond = [feature for feature in (*numpy, *opencv) if feature.startswith(("AVX512", "X86_V4", "IPP"))]
    has_baseline = "AVX2" in opencv and not {"AVX2", "X86_V3"}.isdisjoint(numpy)
    if has_baseline and not beyond and blas == ("Haswell",):
        return PORTABLE
    importlib.import_module("scipy.linalg")  # brings a BLAS of its own
    return f"numpy {' '.join(numpy) or 'baseline'}, OpenCV {' '.join(opencv)}, BLAS {' '.join(_blas()) or 'unknown'}"


def expected_instruction_set() -> str:
    """Return what a process that this one starts computes with."""
    return used_instruction_set() if os.environ.get(OPT_OUT) == "0" or lacking() else PORTABLE


def environment_alike() -> dict[str, str]:
    """Return the variables with which a process that this one starts computes as this one does.

    A program that has loaded numpy before graphnav is not pinned, and its processes are not to be, either.
    """
    return {} if used_instruction_set() == expected_instruction_set() else {OPT_OUT: "0"}


def require_portable() -> None:
    """Raise UserError if this process does not compute with `PORTABLE`."""
    if used_instruction_set() == PORTABLE:
        return
    if what := lacking():
        raise UserError.of(f"{what}, which portable runs need", "run without 'portable', and compare only such runs")
    hint = "import graphnav before numpy, OpenCV and scipy"
    if os.environ.get(OPT_OUT) == "0":
        hint = f"run without --no-portable, and without {OPT_OUT}=0 in the environment"
    raise UserError.of(f"a portable run needs {PORTABLE}, but this process has {used_instruction_set()}", hint)


def _numpy() -> tuple[str, ...]:
    """Return the features that numpy has code for and uses."""
    return tuple(np.show_config(mode="dicts")["SIMD Extensions"].get("found", ()))


def _opencv() -> tuple[str, ...]:
    """Return the features that OpenCV has code for and uses; those it does not use end with a question mark."""
    words = cv2.getCPUFeaturesLine().split()
    used = [word.lstrip("*").replace("AVX512-", "AVX512_") for word in words if not word.endswith("?")]
    return (*used, "IPP") if cv2.ipp.useIPP() else tuple(used)


def _blas() -> tuple[str, ...]:
    """Return the kernels of all loaded BLAS libraries."""
    found = [one for one in threadpool_info() if one["user_api"] == "blas"]
    return tuple(sorted({one.get("architecture") or one["internal_api"] for one in found}))
