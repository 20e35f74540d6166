"""A camera of 20 Hz whose stamps jitter, of python-lcm alone: ``jittering_camera.py URL N`` prints the stamps."""

from __future__ import annotations

import json
import sys
import time

import lcm
import numpy as np
from graphnav_lcm import image_t

RATE_HZ = 20.0
JITTER_S = 0.015
ROWS, COLS = 120, 160


def main() -> None:
    """Publish N frames of a floor that moves by, each stamped up to 15 ms early or late."""
    bus, n_frames = lcm.LCM(sys.argv[1]), int(sys.argv[2])
    random = np.random.default_rng(0)
    floor = np.kron(random.integers(40, 200, (ROWS // 4, COLS // 4)), np.ones((4, 4))).astype(np.uint8)
    begin_ns, stamps = time.time_ns(), []
    for seq in range(n_frames):
        due_ns = begin_ns + round(seq / RATE_HZ * 1e9)
        time.sleep(max(0.0, (due_ns - time.time_ns()) * 1e-9))
        image = image_t()
        image.utime = due_ns // 1000 + round(random.uniform(-JITTER_S, JITTER_S) * 1e6)
        image.seq, image.step_px, image.rows, image.cols, image.channels = seq, 1, ROWS, COLS, 1
        image.data = np.roll(floor, seq, axis=0).tobytes()
        image.size = len(image.data)
        bus.publish("CAMERA", image.encode())
        stamps.append(image.utime)
    sys.stdout.write(json.dumps(stamps))


if __name__ == "__main__":
    main()
