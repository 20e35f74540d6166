"""A source of images: a video file, a camera or a stream."""

from __future__ import annotations

from pathlib import Path

from graphnav import Image, ParamError, Source, param
from graphnav_io.capture import OPEN_TIMEOUT_S, check_camera, first_frame, is_camera, is_stream, open_capture
from graphnav_io.frames import Frames
from graphnav_io.pictures import PictureFrames, check_pictures, find_pictures, is_pictures
from graphnav_io.playback import next_image
from graphnav_io.preparation import Prepared

PICTURES_HZ = 10.0


class Video(Prepared, Source):
    """A video file, a camera or a stream, one frame per firing, in red-green-blue; the last one ends the run.

    A folder or pattern of pictures is read as by `Images`, and frames are prepared as there. A frame that cannot be
    decoded, and a file that ends before the last frame that it declares, stop the run.
    """

    path: Path = param(
        doc="a video file, a camera (its number, or its file such as /dev/video0), a URL, or a folder or pattern of "
        "pictures"
    )
    rate_hz: float = param(
        0.0,
        ge=0.0,
        le=10_000.0,
        doc="firings per second, one frame each; 0: the rate of the video, 10 for pictures",
    )
    open_timeout_s: float = param(
        OPEN_TIMEOUT_S,
        ge=0.001,
        le=3600.0,
        doc="how long a stream is waited for when it is opened; Ctrl-C ends the wait",
    )

    def check(self) -> None:
        """Check that the video opens and that its first frame can be decoded; only a run opens cameras and streams."""
        super().check()
        if self.is_remote():
            return
        if is_camera(self.path):
            check_camera(self.path)
            return
        if is_pictures(self.path):
            self.check_picture(check_pictures(self.path))
            return
        frames = open_capture(self.path)
        try:
            self.check_picture(first_frame(frames))
        finally:
            frames.close()
        self._check_rate(frames)

    def is_remote(self) -> bool:
        """Return whether the video is a stream."""
        return is_stream(self.path)

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Open the video at its first frame."""
        self.close()
        self._frames: Frames | None = self._open()
        self._check_rate(self._frames)
        self._preparation = self.preparation()

    def rate(self) -> float:
        """Return the given rate, else that of the video."""
        assert self._frames is not None
        return self.rate_hz or self._frames.rate_hz or PICTURES_HZ

    def step(self) -> Image:
        """Return the next frame."""
        assert self._frames is not None
        return next_image(self._frames, self._preparation)

    def close(self) -> None:
        """Close the file or device."""
        frames: Frames | None = getattr(self, "_frames", None)
        if frames is not None:
            frames.close()
        self._frames = None

    def _check_rate(self, frames: Frames) -> None:
        if not (self.rate_hz or frames.rate_hz or is_pictures(self.path)):
            raise ParamError("path", f"'{self.path}' does not declare a frame rate", "set 'rate_hz'")

    def _open(self) -> Frames:
        if is_pictures(self.path) and not self.is_remote():
            return PictureFrames(find_pictures(self.path))
        return open_capture(self.path, self.open_timeout_s)
