"""One thread per process: thread counts change results and timings; parallel work uses processes."""

from __future__ import annotations

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENCV_FOR_THREADS_NUM": "1",
}
"""The environment of a single-threaded process; it must be set before numpy and OpenCV are loaded."""
