"""The graphs ``video_plane`` and ``video_prior`` run on recorded pictures and draw what they found."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from graphnav_view.signals import Signals

from graphnav import Flow, Image, Plane, Recording
from graphnav.core.cli import main

SHIFT_PX = (3.0, 2.0)
FRAMES = 8


def pictures() -> list[np.ndarray]:
    """Return crops of one texture that moves right and down by ``SHIFT_PX`` a frame."""
    noise = np.random.default_rng(5).uniform(0, 255, (400, 400, 3)).astype(np.float32)
    texture = np.clip((cv2.GaussianBlur(noise, (0, 0), 2.0) - 127) * 4 + 127, 0, 255).astype(np.uint8)
    right, down = (int(shift) for shift in SHIFT_PX)
    return [texture[100 - down * k : 220 - down * k, 100 - right * k : 260 - right * k] for k in range(FRAMES)]


@pytest.fixture(params=["folder of JPEGs", "MP4"])
def drive(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """Return the same drive as a folder of pictures and as a video."""
    if request.param == "MP4":
        path = tmp_path / "drive.mp4"
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (160, 120))
        for picture in pictures():
            writer.write(picture)
        writer.release()
        return path
    folder = tmp_path / "some frames"
    folder.mkdir()
    for k, picture in enumerate(pictures()):
        cv2.imwrite(str(folder / f"{k:03d}.jpg"), picture)
    return folder


def run(graph: str, drive: Path, folder: Path, *sets: str) -> None:
    """Run a graph on a drive, with its pictures and a full log."""
    words = [word for one in (f"camera.path={drive}", *sets) for word in ("--set", one)]
    assert main(["run", graph, *words, "-o", str(folder), "--no-tap", "--video", "--record", "all"]) == 0
    assert {"panels.png", "video.mp4", "run.lcmlog"} <= {path.name for path in folder.iterdir()}
    assert not (folder / "map.png").exists()


@pytest.mark.parametrize(("crop", "rows"), [((), 72), (("camera.crop_top_ratio=0",), 120)])
def test_a_recorded_drive_gives_sensible_flow_panels_and_a_video(
    drive: Path, tmp_path: Path, crop: tuple[str, ...], rows: int
) -> None:
    run("video_plane", drive, tmp_path / "run", *crop)
    with Recording(tmp_path / "run" / "run.lcmlog") as recording:
        signals = Signals(recording)
        images = [image for _, image in signals.all(Image)]
        flows = [flow for _, flow in signals.all(Flow)]
        planes = [plane for _, plane in signals.all(Plane)]
    assert {image.pixels.shape for image in images} == {(rows, 160, 3)}
    assert len(flows) == FRAMES - 1
    for flow in flows:
        assert flow.valid.shape == (rows, 160)  # of the very picture that is shown
        assert flow.valid.mean() > 0.7
        assert np.median(flow.uv_px[flow.valid != 0], axis=0) == pytest.approx(SHIFT_PX, abs=0.1)
    for plane in planes:
        assert plane.valid.shape == (rows // 4, 40)
        assert plane.obstacle_ratio < 0.05


def test_the_prior_stands_between_plane_and_steering(drive: Path, tmp_path: Path) -> None:
    run("video_prior", drive, tmp_path / "run")
    with Recording(tmp_path / "run" / "run.lcmlog") as recording:
        assert Signals(recording).channel(Plane) == "prior.plane"
        count = recording.count("plane.plane")
        assert count == recording.count("prior.plane") == FRAMES - 1
        for index in range(count):
            plane, found = (recording.message(f"{stage}.plane", index)[-1] for stage in ("plane", "prior"))
            assert isinstance(plane, Plane)
            assert isinstance(found, Plane)
            assert np.array_equal(found.valid, plane.valid)
            assert found.obstacle[found.score > 0.5].all()
            assert found.obstacle[:3][found.valid[:3] != 0].any()
            assert not found.obstacle[9:].any()
