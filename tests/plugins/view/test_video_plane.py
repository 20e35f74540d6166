"""The graph ``video_plane`` runs on recorded pictures and draws what it found."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from graphnav_view.signals import Signals

from graphnav import Flow, Plane, Recording
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


def test_a_recorded_drive_gives_sensible_flow_panels_and_a_video(drive: Path, tmp_path: Path) -> None:
    run = tmp_path / "run"
    assert (
        main(
            [
                "run",
                "video_plane",
                "--set",
                f"camera.path={drive}",
                "-o",
                str(run),
                "--no-tap",
                "--video",
                "--record",
                "all",
            ]
        )
        == 0
    )
    assert {"panels.png", "video.mp4", "run.lcmlog"} <= {path.name for path in run.iterdir()}
    assert not (run / "map.png").exists()
    with Recording(run / "run.lcmlog") as recording:
        signals = Signals(recording)
        flows = [flow for _, flow in signals.all(Flow)]
        planes = [plane for _, plane in signals.all(Plane)]
    assert len(flows) == FRAMES - 1
    for flow in flows:
        assert flow.valid.mean() > 0.7
        assert np.median(flow.uv_px[flow.valid != 0], axis=0) == pytest.approx(SHIFT_PX, abs=0.1)
    assert max(plane.obstacle_ratio for plane in planes) < 0.05
