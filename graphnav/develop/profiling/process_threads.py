"""Count the threads of this process's libraries, which change times and results."""

from __future__ import annotations

import sys

from threadpoolctl import threadpool_info


def process_threads() -> dict[str, int]:
    """Return the number of threads that BLAS may use, and OpenCV where a plugin has loaded it."""
    found = {"blas": max((pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"), default=1)}
    opencv = sys.modules.get("cv2")  # the core does not import it
    if opencv is not None:
        found["opencv"] = opencv.getNumThreads()
    return found
