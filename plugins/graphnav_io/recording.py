"""A source of images and motions: a recorded drive."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from graphnav import Finished, Image, Motion, Odometry, ParamError, Source, Stamp, param
from graphnav import Recording as Log
from graphnav_io.frames import Frames
from graphnav_io.logs import LogFrames, channels_of, open_log_frames
from graphnav_io.odometry import Track, logged_odometry, read_odometry
from graphnav_io.preparation import Prepared
from graphnav_io.sequence import Sequence, Timeline, open_sequence

ROUNDING_US = 10
"""Stamps of a live run are rounded."""


class Drive(NamedTuple):
    """A picture, and the motion since the one before."""

    image: Image
    motion: Motion | None


class Recording(Prepared, Source):
    """Pictures and odometry of a recorded drive, at the recorded times; the last picture ends the run.

    It takes the place of a world: ``image`` is stamped with its time since the first picture, ``motion`` covers exactly
    the interval since the picture before, interpolated from odometry whose samples have other times, by the same clock.
    Between two samples the robot is taken to drive on an arc. No motion is published where the odometry does not cover
    the interval, has a gap of more than 3 typical periods in it, or is not given: stages that need it then wait for the
    next picture.

    A log, of LCM or a ROS 2 bag, has both: channels of `Image` and `Odometry`, topics of ``sensor_msgs/Image`` or
    ``CompressedImage`` (8 bits, gray or colour, JPEG, PNG) and ``nav_msgs/Odometry``, by the stamps of their headers.

    Pictures are prepared as by `Images`. In a live run, pictures whose time has passed are skipped.
    """

    path: Path = param(
        doc="a folder or pattern of pictures, a video file, an LCM log (.lcmlog), or a ROS 2 bag: its folder, or an "
        ".mcap or .db3 file of it (extra: bags)"
    )
    image_channel: str | None = param(
        None, doc="channel of Image in the log, or topic in the bag, that 'path' is; null takes the only one in it"
    )
    times: Path | None = param(
        None,
        doc="csv with a header, a column of times (time_us, time_s, ...; time is in seconds), and for pictures a "
        "column file; null: pictures are named by their times in microseconds, a video has its rate",
    )
    rate_hz: float = param(
        0.0, ge=0.0, le=10_000.0, doc="pictures per second where no times are recorded; 0 takes the recorded ones"
    )
    start_s: float = param(0.0, doc="time of the first picture by the clock of the odometry, for a constant rate")
    odometry: Path | None = param(
        None,
        doc="csv with a header and columns time, x, y, yaw (m, rad) or time, v, omega (m/s, rad/s), or an LCM log "
        "(.lcmlog), or a ROS 2 bag; null takes the odometry in the log or bag that 'path' is, and publishes no motion "
        "where there is none",
    )
    columns: tuple[str, ...] | None = param(
        None,
        doc="columns of the odometry's csv: time, x, y, yaw or time, v, omega, in this order; null finds them by name",
    )
    odometry_channel: str | None = param(
        None, doc="channel of Odometry in the log, or topic in the bag; null takes the only one in it"
    )

    def check(self) -> None:
        """Check that pictures, times and odometry can be read and have times in common."""
        super().check()
        frames, timeline = self._open()
        try:
            pixels, track = frames.read(), self._track(frames)
        except ValueError as error:
            raise ParamError("path", str(error)) from error
        finally:
            frames.close()
        assert pixels is not None, "an open sequence has a first frame"
        self.check_picture(pixels)
        if track is not None:
            first_us, last_us = timeline.at_us(0), timeline.last_us
            if track.last_us <= first_us or (last_us is not None and track.first_us >= last_us):
                until = "" if last_us is None else f" to {last_us * 1e-6:.3f}"
                raise ParamError(
                    "odometry",
                    f"the odometry is of {track.first_us * 1e-6:.3f} to {track.last_us * 1e-6:.3f} s, "
                    f"but the pictures are of {first_us * 1e-6:.3f}{until} s",
                    "give both by one clock: with 'times', or with 'start_s'",
                )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Begin with the first picture."""
        self.close()
        self._sequence: Sequence | None = self._open()
        self._odometry = self._track(self._sequence.frames)
        self._preparation = self.preparation()
        self._next = 0
        self._begin_us: int | None = None
        self._last_us: int | None = None

    def rate(self) -> float:
        """Return the typical rate of the pictures."""
        assert self._sequence is not None
        return self._sequence.timeline.rate_hz

    def due_us(self, firing: int) -> int:
        """Return the time of a picture since the first one."""
        assert self._sequence is not None
        timeline = self._sequence.timeline
        return timeline.at_us(firing) - timeline.at_us(0)

    def step(self, utime: Stamp) -> Drive:
        """Return the picture of this time, and the motion since the one before.

        Raises
        ------
        ValueError
            A picture cannot be decoded, has another size or has no recorded time.
        """
        assert self._sequence is not None
        frames, timeline = self._sequence
        if self._begin_us is None:
            self._begin_us = utime
        while self._begin_us + self.due_us(self._next + 1) <= utime + ROUNDING_US and not frames.at_end:
            self._next += 1
            frames.read()
        pixels = frames.read()
        if pixels is None:
            raise Finished("end")
        if not timeline.has(self._next):
            raise ValueError(f"frame {self._next} has no row in '{self.times}'; add the missing times")
        drive = Drive(Image(pixels=self._preparation.apply(pixels)), self._motion(timeline.at_us(self._next)))
        self._next += 1
        if frames.at_end:
            raise Finished("end", drive)
        return drive

    def close(self) -> None:
        """Close the file."""
        sequence: Sequence | None = getattr(self, "_sequence", None)
        if sequence is not None:
            sequence.frames.close()
        self._sequence = None

    def _motion(self, utime: int) -> Motion | None:
        begin, self._last_us = self._last_us, utime
        return None if begin is None or self._odometry is None else self._odometry.motion(begin, utime)

    def _open(self) -> Sequence:
        if not Log.is_log(self.path):
            if self.image_channel is not None:
                what = f"'image_channel' is '{self.image_channel}', but '{self.path}' is not a log"
                raise ParamError("image_channel", what, "remove it, or give a log or a ROS 2 bag as 'path'")
            return open_sequence(self.path, self.times, self.rate_hz, self.start_s)
        for name in ("times", "rate_hz", "start_s"):
            if getattr(self, name):
                what = f"'{name}' is {getattr(self, name)}, but '{self.path}' has the times of its pictures"
                raise ParamError(name, what, "remove it")
        frames = open_log_frames(self.path, self.image_channel)
        return Sequence(frames, Timeline(frames.utimes))

    def _track(self, frames: Frames) -> Track | None:
        """Return the odometry that is given, else that of the log of the pictures; None where there is none."""
        if self.odometry is not None:
            return read_odometry(self.odometry, self.columns, self.odometry_channel)
        if isinstance(frames, LogFrames) and (self.odometry_channel or channels_of(frames.log, Odometry)):
            return logged_odometry(frames.log, self.odometry_channel)
        return None
