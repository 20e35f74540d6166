"""One thread a process: thread counts change results and times, parallel work is many processes."""

from __future__ import annotations

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENCV_FOR_THREADS_NUM": "1",
}
"""The environment of a process with one thread; it must stand before numpy and OpenCV load."""
