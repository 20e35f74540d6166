"""Recorded odometry as poses over time: from a csv file or a log."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from graphnav import GraphnavError, Motion, Odometry, ParamError, Recording
from graphnav.arrays import Doubles, Longs
from graphnav_io.csv_file import CsvFile
from graphnav_io.logs import channel_of, opened_log

X, Y = ("x", "x_m"), ("y", "y_m")
YAW = ("yaw", "yaw_rad", "yaw_deg", "theta", "theta_rad", "theta_deg", "heading", "heading_rad", "heading_deg")
V = ("v", "v_mps", "speed", "speed_mps")
OMEGA = ("omega", "omega_radps", "omega_degps", "w", "w_radps", "yaw_rate", "yaw_rate_radps", "yaw_rate_degps")
WRITE = "name them time, x, y, yaw or time, v, omega, with units as suffixes (time_us, yaw_deg), or set 'columns'"
MAX_PERIODS = 3.0
"""Longest gap, in typical periods, that is interpolated."""
MAX_M, MAX_RAD = 1e9, 1e9
"""Limits of poses; UTM coordinates are below 1e7 m."""


class Track(NamedTuple):
    """Poses over time, in a frame of their own.

    ``utimes``: int64 (n,), increasing. ``position_m``: complex (n,), x + iy. ``yaw_rad``: (n,), not wrapped.
    """

    utimes: Longs
    position_m: npt.NDArray[np.complex128]
    yaw_rad: Doubles

    @property
    def first_us(self) -> int:
        """The time of the first sample."""
        return int(self.utimes[0])

    @property
    def last_us(self) -> int:
        """The time of the last sample."""
        return int(self.utimes[-1])

    def motion(self, begin: int, end: int) -> Motion | None:
        """Return the motion between two times, None where the samples do not cover it or have a gap in it.

        Between two samples the robot drives on an arc of constant speed and turning rate.
        """
        first = int(np.searchsorted(self.utimes, begin, "right")) - 1
        last = int(np.searchsorted(self.utimes, end, "left"))
        if first < 0 or last >= len(self.utimes):
            return None
        periods = np.diff(self.utimes)
        if periods[first:last].max() > MAX_PERIODS * np.median(periods):
            return None
        (here, yaw), (there, end_yaw) = self._at(begin), self._at(end)
        moved = (there - here) * np.exp(-1j * yaw)
        return Motion(
            forward_m=float(moved.real),
            left_m=float(moved.imag),
            turn_rad=float(end_yaw - yaw),
            interval_us=end - begin,
        )

    def _at(self, utime: int) -> tuple[complex, float]:
        after = max(1, int(np.searchsorted(self.utimes, utime, "left")))
        before = after - 1
        share = float(utime - self.utimes[before]) / float(self.utimes[after] - self.utimes[before])
        turn = float(self.yaw_rad[after] - self.yaw_rad[before])
        chord = complex(self.position_m[after] - self.position_m[before])
        # Of an arc from 0 with turn t the chord at share s is proportional to exp(i s t) - 1.
        along = share if abs(turn) < 1e-9 else np.expm1(1j * share * turn) / np.expm1(1j * turn)
        return complex(self.position_m[before] + chord * along), float(self.yaw_rad[before] + share * turn)


def read_odometry(path: Path, columns: tuple[str, ...] | None, channel: str | None) -> Track:
    """Return the odometry in a csv file, or of a channel of an LCM log (``.lcmlog``) or of a ROS 2 bag.

    ``columns``: the csv's columns of time, x, y, yaw or of time, v, omega; None finds them by their names. Speeds are
    integrated: between two rows the robot drives at their mean. ``channel``: None is the log's only Odometry.

    Raises
    ------
    ParamError
        The file cannot be read or lacks what is needed.
    """
    if not Recording.is_log(path):
        return _checked(path, _read_csv(path, columns))
    with opened_log("odometry", path, "give an LCM log (.lcmlog), a ROS 2 bag or a csv file") as log:
        return logged_odometry(log, channel)


def logged_odometry(log: Recording, channel: str | None) -> Track:
    """Return the odometry of a channel of an open log, None the only one.

    Raises
    ------
    ParamError
        The log lacks what is needed.
    """
    wanted = channel_of(log, Odometry, channel, "odometry_channel")
    try:
        samples = {utime: one for utime, _, one in log.messages(wanted) if isinstance(one, Odometry)}
    except GraphnavError as error:
        raise ParamError("odometry", str(error), "give another log, or a csv file") from error
    utimes = np.array(sorted(samples), np.int64)
    poses = np.array([(samples[t].x_m, samples[t].y_m, samples[t].yaw_rad) for t in utimes.tolist()], np.float64)
    poses = poses.reshape(-1, 3)
    return _checked(log.path, Track(utimes, poses[:, 0] + 1j * poses[:, 1], np.unwrap(poses[:, 2])))


def _checked(path: Path, track: Track) -> Track:
    if len(track.utimes) < 2:
        raise ParamError("odometry", f"'{path}' holds a single sample", "record the drive, at 10 Hz or more")
    if not (np.abs(track.position_m).max() <= MAX_M and np.abs(track.yaw_rad).max() <= MAX_RAD):
        what = f"'{path}' leads farther than {MAX_M:g} m away, or turns by more than {MAX_RAD:g} rad"
        raise ParamError("odometry", what, "give metres and radians, or m/s and rad/s")
    return track


def _read_csv(path: Path, columns: tuple[str, ...] | None) -> Track:
    table = CsvFile("odometry", path)
    if columns is not None:
        names = tuple(name.lower() for name in columns)
        if len(names) not in (3, 4):
            raise ParamError("columns", f"'columns' has {len(names)} names", "give time, x, y, yaw or time, v, omega")
        for name in names:
            if name not in table.names:
                raise table.missing(f"no column '{name}'", "correct 'columns'")
    else:
        names = _recognised(table)
    utimes = table.utimes(names[0])
    if len(names) == 4:
        x, y = table.numbers(names[1]), table.numbers(names[2])
        return Track(utimes, x + 1j * y, np.unwrap(_radians(table, names[3])))
    return _integrated(utimes, table.numbers(names[1]), _radians(table, names[2]))


def _recognised(table: CsvFile) -> tuple[str, ...]:
    time = table.time_column()
    if time is None:
        raise table.missing("no column of times", WRITE)
    for kinds in ((X, Y, YAW), (V, OMEGA)):
        found = [table.find(kind) for kind in kinds]
        if all(found):
            return (time, *(name for name in found if name is not None))
    raise table.missing("neither x, y and yaw nor v and omega", WRITE)


def _radians(table: CsvFile, name: str) -> Doubles:
    values = table.numbers(name)
    return np.radians(values) if name.endswith(("_deg", "_degps")) else values


@np.errstate(over="ignore", invalid="ignore")
def _integrated(utimes: Longs, v_mps: Doubles, omega_radps: Doubles) -> Track:
    elapsed_s = np.diff(utimes) * 1e-6
    turns = elapsed_s * (omega_radps[1:] + omega_radps[:-1]) / 2
    yaw_rad = np.concatenate([[0.0], np.cumsum(turns)])
    chords = elapsed_s * (v_mps[1:] + v_mps[:-1]) / 2 * np.sinc(turns / (2 * np.pi))
    steps = chords * np.exp(1j * (yaw_rad[:-1] + turns / 2))
    return Track(utimes, np.concatenate([[0j], np.cumsum(steps)]), yaw_rad)
