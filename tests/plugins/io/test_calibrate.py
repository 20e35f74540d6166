"""``graphnav calibrate`` on boards that are rendered through cameras that are known."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from graphnav_io.boards import BoardFinder
from graphnav_io.lens import Lens
from graphnav_io.prepare import Prepare
from PIL import Image as Picture
from testbed.rendered_board import BoardCamera

from graphnav import CalibrationBoard, Graph, Image, Mount, UserError, calibrate, load
from graphnav.arrays import Bytes
from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter

BOARD = CalibrationBoard(6, 4, 0.06)
ROWS, COLS = 120, 160
MOUNT, ROLL_DEG = Mount(0.9, 72.0, 70.0, 0.0), 2.0
MATRIX = MOUNT.intrinsics(ROWS, COLS) + np.array([[0.0, 0.0, 3.0], [0.0, 0.0, -2.0], [0.0, 0.0, 0.0]])
CAMERA = BoardCamera(
    Lens(MATRIX, np.array([-0.2, 0.04, 0.0, 0.0, 0.0]), is_fisheye=False), ROWS, COLS, BOARD, noise_gray=2, blur_px=0.4
)
FISHEYE = replace(CAMERA, lens=Lens(MATRIX, np.array([-0.02, 0.005, 0.0, 0.0]), is_fisheye=True))
TILT_DEG = 1.0
"""A pixel of these small pictures is half a degree; tools/check_calibration.py has larger ones."""
WORDS = ("--board", "6x4", "--square", "0.06")
MIDDLE = (80.0, 60.0)


@cache
def hand_pictures(camera: BoardCamera = CAMERA, n_pictures: int = 20) -> tuple[Bytes, ...]:
    rng = np.random.default_rng(3)
    return tuple(camera.picture(camera.hand_pose(rng), rng) for _ in range(n_pictures))


@cache
def floor_pictures(mount: Mount = MOUNT) -> tuple[Bytes, ...]:
    rng = np.random.default_rng(4)
    places = ((80.0, 60.0), 0.0), ((60.0, 65.0), 25.0), ((95.0, 55.0), 75.0)
    return tuple(CAMERA.picture(CAMERA.floor_pose(mount, ROLL_DEG, *place), rng) for place in places)


Write = Callable[[str, Sequence[Bytes]], Path]


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    """Return a function that writes pictures into a folder of the working folder."""
    monkeypatch.chdir(tmp_path)

    def written(name: str, pictures: Sequence[Bytes]) -> Path:
        (tmp_path / name).mkdir()
        for number, pixels in enumerate(pictures):
            cv2.imwrite(str(tmp_path / name / f"{number}.png"), pixels)
        return Path(name)

    return written


def loaded(base: str = "navigate_robot") -> Graph:
    Path("my_graph.yaml").write_text(f"extends: [{base}, my_camera.yaml]\n")
    return load("my_graph.yaml")


def test_a_camera_is_found_and_a_graph_extends_it(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    words = [str(write("pictures", hand_pictures())), *WORDS, "--floor", str(write("floor", floor_pictures()))]
    assert main(["calibrate", *words]) == 0
    told = capsys.readouterr().out
    assert "reprojection error, rms [px]" in told
    assert told.splitlines()[-3:] == ["my_camera.yaml", "my_camera.calibration.yaml", "my_camera.png"]
    with Picture.open("my_camera.png") as sheet:
        assert sheet.size[0] == 5 * 328
    nodes = {node.name: node for node in loaded().nodes}
    for name in ("egomotion", "local", "guard"):
        found = nodes[name].params
        assert found["camera_height_m"] == pytest.approx(MOUNT.height_m, rel=0.02)
        assert found["tilt_deg"] == pytest.approx(MOUNT.tilt_deg, abs=TILT_DEG)
        assert found["fov_deg"] == pytest.approx(MOUNT.fov_deg, abs=1.5)  # a little zoomed: no corner is black
    assert [one.channel.ref for one in nodes["flow"].inputs if one.channel] == ["prepare.image"]
    assert "camera.image" in [one.channel.ref for one in nodes["guard"].inputs if one.channel]


def test_the_prepared_picture_is_that_of_the_mounting_that_stages_are_told(write: Write) -> None:
    found = calibrate(
        [write("pictures", hand_pictures())], board="6x4", square_m=0.06, floor=[write("floor", floor_pictures())]
    )
    assert found.lens is not None
    assert found.lens.fx_px.value == pytest.approx(MATRIX[0, 0], rel=0.01)
    assert found.lens.cx_px.value == pytest.approx(MATRIX[0, 2], abs=1.5)
    told = yaml.safe_load(Path("my_camera.yaml").read_text())["stages"]["local"]["with"]
    prepare = Prepare(calibration=Path("my_camera.calibration.yaml"), rectify=True, size=(COLS, ROWS))
    prepare.check()
    prepare.reset(0)
    pose = CAMERA.floor_pose(MOUNT, ROLL_DEG, (70.0, 62.0), 15.0)
    seen = prepare.step(Image(pixels=CAMERA.picture(pose, np.random.default_rng(9)))).pixels
    corners = BoardFinder(BOARD).find(seen).points_px
    # back on the floor, by the mounting: the squares have their size, and the floor is where it is
    mount = Mount(told["camera_height_m"], told["tilt_deg"], told["fov_deg"], 0.0)
    floor = np.linalg.inv(mount.floor_to_pixels(ROWS, COLS)) @ np.vstack([corners.T, np.ones(len(corners))])
    grid = (floor[:2] / floor[2]).T.reshape(4, 6, 2)
    for axis in (0, 1):
        assert np.linalg.norm(np.diff(grid, axis=axis), axis=-1) == pytest.approx(0.06, rel=0.08)
    ray = CAMERA.lens.rays(np.array([[70.0, 62.0]]))[0]
    c, s = np.cos(np.radians(ROLL_DEG)), np.sin(np.radians(ROLL_DEG))
    down = (MOUNT.R_CR @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])).T @ [*ray, 1.0]
    assert grid.mean(axis=(0, 1)) == pytest.approx(down[:2] * MOUNT.height_m / -down[2], abs=0.015)
    assert (seen > 0).all()


def test_a_fisheye_is_found(write: Write) -> None:
    found = calibrate([write("pictures", hand_pictures(FISHEYE))], board="6x4", square_m=0.06, fisheye=True)
    assert found.lens is not None
    assert found.lens.fx_px.value == pytest.approx(MATRIX[0, 0], rel=0.01)
    assert found.lens.fx_px.deviation > 0
    assert found.mounting is None
    assert "distortion_model: equidistant" in found.text
    told = yaml.safe_load(Path("my_camera.yaml").read_text())["stages"]["local"]["with"]
    assert set(told) == {"fov_deg"}


def test_a_charuco_board_may_be_cut_off() -> None:
    board = CalibrationBoard(6, 4, 0.06, 0.045)
    camera = replace(
        CAMERA,
        board=board,
        rows=240,
        cols=320,
        lens=Lens(np.diag([2.0, 2.0, 1.0]) @ MATRIX, CAMERA.lens.distortion, is_fisheye=False),
    )
    pose = camera.pose_at((250.0, 120.0), 0.35, (10.0, 5.0, 0.0))
    found = BoardFinder(board).find(camera.picture(pose, np.random.default_rng(1)))
    assert found.fault is None
    assert 8 <= len(found.points_px) < 15
    true = camera.lens.project(found.places_m, cv2.Rodrigues(pose.rotation)[0], pose.place_m)
    assert np.abs(found.points_px - true).max() < 0.5


def test_bad_pictures_are_refused_with_the_reason(write: Write) -> None:
    rng = np.random.default_rng(6)
    pose = CAMERA.pose_at(MIDDLE, 0.55, (15.0, 10.0, 5.0))
    other = replace(CAMERA, board=CalibrationBoard(7, 5, 0.05))
    bad = {
        "no board found": rng.integers(100, 140, (ROWS, COLS)).astype(np.uint8),
        "blurred": replace(CAMERA, blur_px=2.5).picture(pose, rng),
        "": CAMERA.picture(pose, rng),
        "same pose as another": CAMERA.picture(pose, rng),
        "cut off or covered": CAMERA.picture(CAMERA.pose_at((150.0, 60.0), 0.45, (0.0, 0.0, 0.0)), rng),
        "another board": other.picture(other.pose_at(MIDDLE, 0.45, (5.0, 5.0, 0.0)), rng),
        "has 200x150 pixels, but most have 160x120": cv2.resize(CAMERA.picture(pose, rng), (200, 150)),
    }
    pictures = write("pictures", [*hand_pictures()[:12], *bad.values()])
    (pictures / "19.png").write_bytes((pictures / "0.png").read_bytes()[:500])
    found = calibrate([pictures], board="6x4", square_m=0.06)
    refusals = [one.refusal for one in found.pictures[12:]]
    assert [text.partition(":")[0] for text in refusals] == [
        *bad,
        f"'{Path('pictures', '19.png')}' is truncated or damaged",
    ]


def refusal(write: Write, pictures: Sequence[Bytes], floor: Sequence[Bytes] = (), board: str = "6x4") -> str:
    folders = [write("floor", floor)] if floor else []
    with pytest.raises(UserError) as error:
        calibrate([write("pictures", pictures)], board=board, square_m=0.06, floor=folders)
    assert Path("my_camera.png").exists()
    assert not Path("my_camera.yaml").exists()
    return str(error.value)


def test_too_few_pictures_are_refused(write: Write) -> None:
    assert refusal(write, [hand_pictures()[0]] * 9) == (
        "PICTURES: 1 of 9 pictures can be used, but 8 are needed (8 same pose as another)\n"
        "  take 20 with the complete board, each from another side"
    )


def test_another_board_than_named_is_told(write: Write) -> None:
    rng = np.random.default_rng(8)
    pictures = [CAMERA.picture(CAMERA.pose_at(MIDDLE, 0.5, (10.0 + k, 5.0, 0.0)), rng) for k in range(9)]
    told = refusal(write, pictures, board="7x5")
    assert told.endswith("of 9 pictures show 6x4 inner corners, not 7x5\n  give --board 6x4")


def test_parallel_boards_do_not_determine_the_focal_length(write: Write) -> None:
    rng = np.random.default_rng(8)
    places = [((50.0 + 7 * k, 70.0 - 3 * k), 0.5 + 0.03 * k, (0.0, 0.0, 2.0 * k)) for k in range(9)]
    told = refusal(write, [CAMERA.picture(CAMERA.pose_at(*place), rng) for place in places])
    assert told.startswith("PICTURES: the boards of all pictures are parallel")
    assert "turn the board by 20 to 45 degrees" in told


def test_a_floor_picture_off_the_floor_is_left_out_and_two_that_differ_are_refused(write: Write) -> None:
    raised = floor_pictures(Mount(0.7, 72.0, 70.0, 0.0))[0]
    found = calibrate(
        [write("pictures", hand_pictures())],
        board="6x4",
        square_m=0.06,
        floor=[write("floor", [*floor_pictures(), raised])],
    )
    assert [one.refusal.partition(":")[0] for one in found.floor] == ["", "", "", "not on the floor of the others"]
    with pytest.raises(UserError, match="the pictures of the floor do not agree: heights from"):
        calibrate(["pictures"], board="6x4", square_m=0.06, floor=["floor/0.png", "floor/3.png"], force=True)


def test_a_camera_upside_down_is_told_and_turned(write: Write) -> None:
    upside_down = write("pictures", [np.rot90(one, 2) for one in hand_pictures()])
    floor = write("floor", [np.rot90(one, 2) for one in floor_pictures()])
    with pytest.raises(UserError, match="say with --rotate 90, 180 or 270"):
        calibrate([upside_down], board="6x4", square_m=0.06, floor=[floor])
    found = calibrate([upside_down], board="6x4", square_m=0.06, floor=[floor], rotate_deg=180, force=True)
    assert found.mounting is not None
    assert found.mounting.tilt_deg.value == pytest.approx(MOUNT.tilt_deg, abs=TILT_DEG)
    assert found.mounting.roll_deg.value == pytest.approx(ROLL_DEG, abs=TILT_DEG)
    assert yaml.safe_load(Path("my_camera.yaml").read_text())["stages"]["prepare"]["with"]["rotate_deg"] == 180


def test_a_log_of_images_is_read(write: Write) -> None:
    write("unused", [])
    with LogWriter(Path("drive.lcmlog")) as log:
        for number, pixels in enumerate(hand_pictures()):
            utime = number * 500_000
            log.write("camera.image", utime, encode(Image(pixels=pixels), utime, number))
    found = calibrate(["drive.lcmlog"], board="6x4", square_m=0.06)
    assert found.pictures[1].name == "drive.lcmlog@0.5s"
    assert len(found.pictures) == 20


@pytest.mark.parametrize("suffix", ["png", "pdf"])
@pytest.mark.parametrize("charuco", [False, True])
def test_a_printed_board_has_its_size(
    suffix: str, charuco: bool, write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    write("unused", [])
    words = ["--charuco", "--marker", "0.045"] if charuco else []
    assert main(["calibrate", "--print-board", f"board.{suffix}", *WORDS, *words]) == 0
    cols, rows = (8, 6) if charuco else (9, 7)
    assert f"a page of {cols * 60} x {rows * 60} mm" in capsys.readouterr().out
    if suffix == "png":
        with Picture.open("board.png") as page:
            assert page.width / page.info["dpi"][0] * 0.0254 == pytest.approx(cols * 0.06, rel=1e-3)
            gray = np.asarray(page.resize((page.width // 8, page.height // 8)))
        board = replace(BOARD, marker_m=0.045 if charuco else None)
        assert len(BoardFinder(board).find(gray).points_px) == (15 if charuco else 24)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ([], "PICTURES: no picture is named\n  write graphnav calibrate pictures/ --board 9x6 --square 0.025\n"),
        (["nowhere"], "PICTURES: there is no file 'nowhere'\n"),
        (["--marker", "0.01"], "--marker: a checkerboard has no markers\n  add --charuco, or leave it out\n"),
        (["x.png", "--charuco", "--marker", "0.06"], "--marker: a marker of 0.06 m is not smaller than a square"),
        (["x.png", "--charuco", "--dict", "4X4_51"], "--dict: OpenCV has no dictionary '4X4_51'\n  did you mean"),
        (["x.png", "-o", "camera"], "-o: 'camera' is not a YAML file\n  name it my_camera.yaml\n"),
        (["--print-board", "board.jpg"], "--print-board: 'board.jpg' is neither .png nor .pdf\n"),
        (["x.png", "--graph", "navigate_live"], "PICTURES: there is no folder 'x.png'"),
    ],
)
def test_what_cannot_be_used_is_told(
    words: list[str], told: str, write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    write("unused", [])
    assert main(["calibrate", *words, *WORDS]) == 2
    assert capsys.readouterr().err.startswith(told)
