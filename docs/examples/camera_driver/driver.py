"""A camera driver: publishes a video, or a folder of JPEG files, as bot_core.image_t, again and again.

It knows LCM, and nothing of who listens. The package bot_core is what lcm-gen makes of libbot's types.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import lcm
import numpy as np
from bot_core import image_t

MJPEG = 1196444237


def jpegs_of_folder(folder: Path) -> Iterator[bytes]:
    """Yield the JPEG files of a folder, by name, as they are."""
    for file in sorted(folder.glob("*.jpg")):
        yield file.read_bytes()


def jpegs_of_video(file: Path, quality: int) -> Iterator[bytes]:
    """Yield the frames of a video, each as a JPEG."""
    video = cv2.VideoCapture(str(file))
    while True:
        is_read, frame = video.read()
        if not is_read:
            return
        yield cv2.imencode(".jpg", frame, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()


def image_of(jpeg: bytes) -> image_t:
    """Return the message that holds a JPEG, stamped now."""
    height, width = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_GRAYSCALE).shape
    image = image_t()
    image.utime = time.time_ns() // 1000
    image.width, image.height, image.row_stride = width, height, 0
    image.pixelformat = MJPEG
    image.size, image.data = len(jpeg), jpeg
    return image


def main() -> None:
    """Publish until Ctrl-C."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", type=Path, help="a video file or a folder of .jpg files")
    parser.add_argument("--channel", default="CAMERA", help="LCM channel (default: %(default)s)")
    parser.add_argument("--rate", type=float, metavar="HZ", help="default: the video's own; 10 for a folder")
    parser.add_argument("--quality", type=int, default=85, help="of the JPEGs of a video (default: %(default)s)")
    args = parser.parse_args()

    if args.path.is_dir():
        jpegs, own_hz = list(jpegs_of_folder(args.path)), 10.0
    else:
        jpegs = list(jpegs_of_video(args.path, args.quality))
        own_hz = cv2.VideoCapture(str(args.path)).get(cv2.CAP_PROP_FPS)
    period_s = 1.0 / (args.rate or own_hz or 10.0)
    if not jpegs:
        parser.error(f"there is no frame in {args.path}")

    bus = lcm.LCM()  # LCM_DEFAULT_URL, else the group of this machine
    print(f"{len(jpegs)} frames on {args.channel} at {1.0 / period_s:g} Hz; Ctrl-C ends it", flush=True)
    begin_s = time.monotonic()
    try:
        for number, jpeg in enumerate(itertools.cycle(jpegs)):
            time.sleep(max(0.0, begin_s + number * period_s - time.monotonic()))
            bus.publish(args.channel, image_of(jpeg).encode())
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
