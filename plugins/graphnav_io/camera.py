"""A source of images: a camera, in wall time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from graphnav import Finished, Image, LiveSource, Metric, ParamError, param
from graphnav_io.device import Wanted, find_device
from graphnav_io.preparation import Prepared
from graphnav_io.receiver import Picture, PictureReceiver

FOURCC_LETTERS = 4


class Camera(Prepared, LiveSource):
    """A camera of this machine, a network camera or a pipe; a graph with it runs live, one firing a picture.

    A thread receives the pictures and keeps the newest one, so that a device that hangs never holds the run. Pictures
    are stamped when they were taken: by the driver of a camera (V4L2), else when they arrive; a notice tells which. A
    picture that a newer one replaces before the graph was free is not used, and counted.

    When the device is gone, the run goes on without pictures, a notice tells it, and the device is opened again as soon
    as it is back; what reads the pictures sees their age, so that a guard stops the robot. A video file or a folder of
    pictures as ``device`` is played in real time, as a camera would deliver it; its last picture ends the run.

    Pictures are prepared as by `Images`. A picture of another size than the first, as after a change of the device,
    stops the run; with ``size`` it does not.
    """

    metrics = (
        Metric("pictures", help="Pictures that the graph was given.", better="higher"),
        Metric("replaced", help="Pictures that a newer one replaced before the graph was free.", better="lower"),
        Metric("reopened", help="How often the device was gone and opened again.", better="lower"),
    )

    device: Path | str = param(
        doc="a camera by its number, its file (/dev/video0) or a part of its name; a URL (rtsp://, http://); a named "
        "pipe; gst:// and a GStreamer pipeline, where OpenCV has it; or a video file, a folder or pattern of pictures, "
        "played as if it were a camera"
    )
    camera_size: tuple[int, int] | None = param(
        None,
        ge=1,
        le=16384,
        doc="columns and rows to ask the camera for; one that gives another size is told, and used as it is; null: "
        "its own choice",
    )
    rate_hz: float = param(
        0.0,
        ge=0.0,
        le=1000.0,
        doc="pictures per second to ask the camera for, or to play a file with; 0: the camera's choice, the file's "
        "rate, 10 for pictures",
    )
    pixel_format: str | None = param(
        None,
        doc="four letters as 'graphnav cameras' lists them, such as MJPG, which large pictures need on USB 2; null: "
        "what OpenCV takes first",
    )
    exposure_s: float | None = param(
        None,
        gt=0.0,
        le=1.0,
        doc="exposure of a camera; a short one keeps moving pictures sharp; null: automatic",
    )
    timeout_s: float = param(
        5.0, ge=0.1, le=600.0, doc="how long a device may take to open, and a stream to give a picture"
    )

    def check(self) -> None:
        """Check that the device exists; only a run opens it."""
        super().check()
        if self.pixel_format is not None and len(self.pixel_format) != FOURCC_LETTERS:
            what = f"'pixel_format' is '{self.pixel_format}', which is not four letters"
            raise ParamError("pixel_format", what, "write MJPG or YUYV, as 'graphnav cameras' lists them")
        find_device(self.device)

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Open the device; raises ParamError if that fails."""
        self.close()
        self._preparation = self.preparation()
        self._picture: Picture | None = None
        self._n_pictures = self._n_replaced = 0
        wanted = Wanted(self.camera_size, self.rate_hz, self.pixel_format, self.exposure_s, self.timeout_s)
        self._receiver: PictureReceiver | None = PictureReceiver(find_device(self.device), wanted, self.wake)

    def arrived_s(self) -> float | None:
        """Return when the newest picture was taken."""
        assert self._receiver is not None
        ended_s = self._receiver.ended_s  # before the last picture is looked for
        if (newest := self._receiver.take()) is not None:
            self._n_replaced += self._picture is not None
            self._picture = newest
        return ended_s if self._picture is None else self._picture.taken_s

    def step(self) -> Image:
        """Return the newest picture.

        Raises
        ------
        Finished
            The recording has ended.
        ValueError
            It has another size than the first one, or than the calibration.
        """
        if self._picture is None:
            raise Finished("end")
        picture, self._picture = self._picture, None
        self._n_pictures += 1
        return Image(pixels=self._preparation.apply(picture.pixels))

    def notices(self) -> Iterable[str]:
        """Return what became of the device."""
        return () if self._receiver is None else self._receiver.told()

    def summary(self) -> Mapping[str, float]:
        """Return the counts of pictures."""
        receiver = self._receiver
        if receiver is None:
            return {}
        return {
            "pictures": self._n_pictures,
            "replaced": self._n_replaced + receiver.replaced,
            "reopened": receiver.reopened,
        }

    def close(self) -> None:
        """Release the device."""
        receiver: PictureReceiver | None = getattr(self, "_receiver", None)
        if receiver is not None:
            receiver.close()
        self._receiver = None
