"""A recorded drive plays at its own times, with the motion between its pictures; what cannot be read is reported."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from graphnav_io.recording import Drive, Recording

from graphnav import Finished, Odometry, ParamError, Stamp
from graphnav.core.api.run import run
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter
from graphnav.core.record import Recording as Log

START_US = 1_700_000_000_000_000
STAMPS = [0, 49_000, 101_000, 150_000, 320_000]
"""Times of pictures that are not equally far apart, after the first one."""
SPEED_MPS, TURN_RADPS = 0.4, 0.8


@pytest.fixture
def frames(tmp_path: Path) -> Path:
    """Return a folder of pictures that are named by their times."""
    path = tmp_path / "frames"
    path.mkdir()
    for k, stamp in enumerate(STAMPS):
        cv2.imwrite(str(path / f"{START_US + stamp}.png"), np.full((24, 32), 20 * k, np.uint8))
    return path


def circle(at_s: float) -> tuple[float, float, float]:
    """Return the pose of a robot on a circle."""
    yaw, radius = TURN_RADPS * at_s, SPEED_MPS / TURN_RADPS
    return radius * math.sin(yaw), radius * (1 - math.cos(yaw)), yaw


SAMPLES_S = [-0.013 + 0.02 * k for k in range(20)]


def poses(tmp_path: Path, header: str = "time,x,y,yaw", scale: float = 1.0) -> Path:
    path = tmp_path / "odometry.csv"
    rows = [(f"{(START_US * 1e-6 + at) * scale:.9f}", *circle(at)) for at in SAMPLES_S]
    path.write_text("\n".join([header, *(",".join(map(str, row)) for row in rows)]) + "\n")
    return path


def speeds(tmp_path: Path) -> Path:
    path = tmp_path / "odometry.csv"
    rows = [f"{START_US + round(at * 1e6)},{SPEED_MPS},{math.degrees(TURN_RADPS)}" for at in SAMPLES_S]
    path.write_text("\n".join(["#timestamp [us], v_mps, omega_degps", *rows]) + "\n\n")
    return path


def log(tmp_path: Path, *channels: str) -> Path:
    path = tmp_path / "odometry.lcmlog"
    with LogWriter(path) as writer:
        for k, at in enumerate(SAMPLES_S):
            x, y, yaw = circle(at)
            sample = Odometry(x_m=x, y_m=y, yaw_rad=math.remainder(yaw, math.tau), v_mps=0.0, omega_radps=0.0)
            utime = START_US + round(at * 1e6)
            for channel in channels:
                writer.write(channel, utime, encode(sample, utime, k))
    return path


def play(source: Recording) -> list[tuple[int, Drive]]:
    """Return what a source publishes when it is fired when it is due."""
    source.check()
    source.reset(0)
    drives: list[tuple[int, Drive]] = []
    try:
        while True:
            utime = source.due_us(len(drives))
            drives.append((utime, source.step(Stamp(utime))))
    except Finished as finished:
        drives.append((utime, finished.outputs))
    finally:
        source.close()
    return drives


def test_pictures_come_at_their_own_times(frames: Path) -> None:
    drives = play(Recording(path=frames))
    assert [utime for utime, _ in drives] == STAMPS
    assert [int(drive.image.pixels[0, 0]) for _, drive in drives] == [0, 20, 40, 60, 80]
    assert all(drive.motion is None for _, drive in drives)


@pytest.mark.parametrize(
    "write",
    [
        poses,
        lambda folder: poses(folder, "t_ms,X,Y,theta_rad", 1e3),
        lambda folder: poses(folder, "timestamp [ns],x_m,y_m,yaw_rad", 1e9),
        speeds,
        lambda folder: log(folder, "ODOMETRY"),
    ],
)
def test_motion_covers_exactly_the_time_between_two_pictures(
    write: Callable[[Path], Path], frames: Path, tmp_path: Path
) -> None:
    drives = play(Recording(path=frames, odometry=write(tmp_path)))
    assert drives[0][1].motion is None
    for (begin, _), (end, drive) in pairwise(drives):
        elapsed_s = (end - begin) * 1e-6
        x, y, yaw = circle(elapsed_s)
        motion = drive.motion
        assert motion is not None
        assert motion.interval_us == end - begin
        # stamps are rounded to 1 us: 0.4 um, 0.8 urad
        assert (motion.forward_m, motion.left_m, motion.turn_rad) == pytest.approx((x, y, yaw), abs=2e-6)


def test_columns_may_have_any_name(frames: Path, tmp_path: Path) -> None:
    odometry = poses(tmp_path, "when,east,north,course")
    drives = play(Recording(path=frames, odometry=odometry, columns=("when", "East", "north", "course")))
    assert all(drive.motion is not None for _, drive in drives[1:])


def test_times_may_be_listed_in_a_csv(frames: Path, tmp_path: Path) -> None:
    times = tmp_path / "times.csv"
    names = sorted(path.name for path in frames.iterdir())
    times.write_text("file,time\n" + "".join(f"{name},{3 + 0.5 * k}\n" for k, name in enumerate(reversed(names))))
    drives = play(Recording(path=frames, times=times))
    assert [utime for utime, _ in drives] == [0, 500_000, 1_000_000, 1_500_000, 2_000_000]
    assert [int(drive.image.pixels[0, 0]) for _, drive in drives] == [80, 60, 40, 20, 0]


def test_a_constant_rate_begins_at_its_start(frames: Path, tmp_path: Path) -> None:
    source = Recording(path=frames, rate_hz=20.0, start_s=START_US * 1e-6, odometry=poses(tmp_path))
    drives = play(source)
    assert [utime for utime, _ in drives] == [0, 50_000, 100_000, 150_000, 200_000]
    assert all(drive.motion is not None for _, drive in drives[1:])


def test_a_video_has_its_rate_or_the_times_of_its_rows(write_video: Callable[..., Path], tmp_path: Path) -> None:
    video = write_video(frames=5, rate_hz=25.0)
    assert [utime for utime, _ in play(Recording(path=video))] == [0, 40_000, 80_000, 120_000, 160_000]
    times = tmp_path / "times.csv"
    times.write_text("time_us\n" + "".join(f"{START_US + stamp}\n" for stamp in STAMPS))
    assert [utime for utime, _ in play(Recording(path=video, times=times))] == STAMPS
    times.write_text("time_us\n1000\n2000\n")
    with pytest.raises(ValueError, match=r"^frame 2 has no row in '.*times\.csv'; add the missing times$"):
        play(Recording(path=video, times=times))


def test_no_motion_is_told_beyond_the_odometry_and_across_a_gap(frames: Path, tmp_path: Path) -> None:
    lines = poses(tmp_path).read_text().splitlines()
    path = tmp_path / "gap.csv"
    path.write_text("\n".join([*lines[:5], *lines[9:15]]))  # to 0.047 s, and from 0.147 s to 0.247 s
    motions = [drive.motion for _, drive in play(Recording(path=frames, odometry=path))]
    assert motions == [None] * len(STAMPS)
    path.write_text("\n".join(lines[:10]))  # to 0.147 s
    motions = [drive.motion for _, drive in play(Recording(path=frames, odometry=path))]
    assert [motion is None for motion in motions] == [True, False, False, True, True]


def test_live_pictures_whose_time_has_passed_are_skipped(frames: Path, tmp_path: Path) -> None:
    source = Recording(path=frames, odometry=poses(tmp_path))
    source.reset(0)
    source.step(Stamp(5_000_000))
    drive = source.step(Stamp(5_000_000 + STAMPS[2]))
    source.close()
    assert int(drive.image.pixels[0, 0]) == 40
    assert drive.motion is not None
    assert drive.motion.interval_us == STAMPS[2]


def test_a_run_in_lockstep_has_the_recorded_stamps(frames: Path, tmp_path: Path) -> None:
    graph = tmp_path / "graph.yaml"
    graph.write_text(
        f"run: {{record: all}}\nstages:\n  drive: {{use: io.recording, with: {{path: '{frames}', "
        f"odometry: '{poses(tmp_path)}'}}}}\n"
    )
    run(graph, folder=tmp_path / "run", pictures=False)
    with Log(tmp_path / "run" / "run.lcmlog") as recording:
        assert recording.utimes("drive.image") == STAMPS
        assert recording.utimes("drive.motion") == STAMPS[1:]


def refusal(**parameters: Any) -> ParamError:
    with pytest.raises(ParamError) as raised:
        Recording(**parameters).check()
    assert raised.value.hint or raised.value.param == "path"
    return raised.value


ODOMETRY_FAULTS = {
    "": "'{path}' holds no rows",
    "time,x,y,yaw\n": "'{path}' holds no rows",
    "x,y,yaw\n1,2,3\n": "'{path}' has no column of times; its columns are x, y, yaw",
    "time,x,y\n1,2,3\n": "'{path}' has neither x, y and yaw nor v and omega; its columns are time, x, y",
    "time,v,omega\n1,2\n": "{path}:2: 2 columns, but the header has 3",
    "time,v,omega\n1,2,3\n\n2,fast,3\n": "{path}:4: 'v' is 'fast', not a finite number",
    "time,v,omega\n1,2,3\n2,nan,3\n": "{path}:3: 'v' is 'nan', not a finite number",
    "time,v,omega\n1,2,3\n1,2,3\n": "{path}:3: 'time' is not later than in the row before",
    "time,v,omega\n1700000000000,2,3\n": "{path}:2: 'time' is 1700000000000, which cannot be seconds",
    "time_us,v,omega\n1,2,3\n1e300,2,3\n": "{path}:3: 'time_us' is 1e300, which is not a time",
    "time_ns,v,omega\n-1e25,2,3\n2,2,3\n": "{path}:2: 'time_ns' is -1e25, which is not a time",
    "time,v,omega\n1,2,3\n": "'{path}' holds a single sample",
    "time,v,omega\n1,1e308,1e308\n2,1e308,0\n3,1,1\n": "'{path}' leads farther than 1e+09 m away, or turns by more "
    "than 1e+09 rad",
    "time,x,y,yaw\n1,0,0,0\n2,0,-1e300,0\n": "'{path}' leads farther than 1e+09 m away, or turns by more than "
    "1e+09 rad",
    "time,v,omega\n1,2,3\n2,2,3\n": "the odometry is of 1.000 to 2.000 s, but the pictures are of 1700000000.000 to "
    "1700000000.320 s",
}


@pytest.mark.parametrize("content", ODOMETRY_FAULTS)
def test_odometry_that_cannot_be_used_is_refused_with_its_line(content: str, frames: Path, tmp_path: Path) -> None:
    path = tmp_path / "odometry.csv"
    path.write_text(content)
    error = refusal(path=frames, odometry=path)
    assert (error.param, error.what) == ("odometry", ODOMETRY_FAULTS[content].format(path=path))


def test_other_files_are_refused(frames: Path, tmp_path: Path) -> None:
    missing = tmp_path / "lost.csv"
    for name in ("odometry", "times"):
        error = refusal(path=frames, **{name: missing})
        assert (error.param, error.what) == (name, f"'{missing}' cannot be read: No such file or directory")
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\xfa")
    assert refusal(path=frames, odometry=binary).what == f"'{binary}' is not a csv file"
    assert refusal(path=frames, odometry=tmp_path / "lost.lcmlog").param == "odometry"


def test_columns_have_to_exist(frames: Path, tmp_path: Path) -> None:
    odometry = poses(tmp_path)
    assert refusal(path=frames, odometry=odometry, columns=("time", "x")).what == "'columns' has 2 names"
    error = refusal(path=frames, odometry=odometry, columns=("time", "vx", "w"))
    assert error.what == f"'{odometry}' has no column 'vx'; its columns are time, x, y, yaw"


def test_a_log_has_to_hold_one_channel_of_odometry_or_the_named_one(frames: Path, tmp_path: Path) -> None:
    path = log(tmp_path, "FRONT", "REAR")
    error = refusal(path=frames, odometry=path)
    assert (error.param, error.what) == ("odometry_channel", f"'{path}' has 2 channels of Odometry")
    assert error.hint == "its channels of Odometry are FRONT, REAR"
    assert refusal(path=frames, odometry=path, odometry_channel="SIDE").what == (
        f"'{path}' has no channel 'SIDE' of Odometry"
    )
    Recording(path=frames, odometry=path, odometry_channel="REAR").check()


def test_names_that_are_not_times_are_refused(folder: Path, tmp_path: Path) -> None:
    error = refusal(path=folder)
    assert (error.param, error.what) == ("times", f"'{folder}/frame_1.png' is not named by its time in microseconds")
    late = tmp_path / f"{10**20}.png"
    cv2.imwrite(str(late), np.zeros((8, 8), np.uint8))
    assert refusal(path=tmp_path).what == f"'{late}' is not named by its time in microseconds"
    late.unlink()
    for number in (1290, 1291, 1292):
        cv2.imwrite(str(tmp_path / f"{number:06d}.png"), np.zeros((8, 8), np.uint8))
    assert refusal(path=tmp_path).what.startswith(f"'{tmp_path}/001290.png' and '001291.png' are 1 us apart")


def test_times_have_to_fit_the_pictures(frames: Path, tmp_path: Path) -> None:
    times = tmp_path / "times.csv"
    times.write_text("file,time\nother.png,1\n")
    assert refusal(path=frames, times=times).what == (
        f"'{times}' lists 1 pictures that 'path' does not hold, the first is 'other.png'"
    )
    times.write_text("time\n1\n")
    assert refusal(path=frames, times=times).what == f"'{times}' has no column of files; its columns are time"
    times.write_text("file\n1\n")
    assert refusal(path=frames, times=times).what == f"'{times}' has no column of times; its columns are file"
    assert refusal(path=frames, times=times, rate_hz=10.0).what == "'rate_hz' is 10, but 'times' is given too"


def test_a_camera_is_not_a_recording() -> None:
    assert "camera 97" in refusal(path=Path("97")).what
