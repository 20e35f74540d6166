"""The picture of one message: what it shows, the box that it fits, and messages that no sane program sends."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav import (
    Components,
    Flow,
    Image,
    LocalMap,
    Map,
    Message,
    PictureContext,
    Plane,
    Potential,
    Recording,
    Scan,
    State,
    Steering,
    Twist,
)
from graphnav.arrays import Bytes
from graphnav.core.catalog import Catalog
from graphnav.core.codec import DecodeError, decode, encode
from graphnav.core.errors import DrawingError
from graphnav.core.messages import Planar, Truth
from graphnav.core.pictures import Pictures

from .conftest import Drive, write_log

KINDS = (Image, Flow, Plane, Potential, State, Map, Steering, Planar, Truth, Components, LocalMap, Scan)
Messages = dict[type[Message], Message]


@pytest.fixture(scope="module")
def pictures() -> Pictures:
    """Return what asks the installed plugins."""
    return Pictures(Catalog())


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Messages:
    """Return the last message of each kind of a drive, a planar flow and truth beside them."""
    recording = Recording(write_log(tmp_path_factory.mktemp("drive") / "run.lcmlog", Drive()))
    found: Messages = {}
    for name in recording.channels:
        message = recording.message(name, -1)[2]
        found[type(message)] = message
    flow, plane = found[Flow], found[Plane]
    assert isinstance(flow, Flow)
    assert isinstance(plane, Plane)
    found[Planar] = Planar(flow.uv_px, flow.valid, flow.uv_px[..., 0], 100_000)
    found[LocalMap] = _small()[LocalMap]
    found[Scan] = _small()[Scan]
    obstacle = plane.obstacle
    identity, variances = np.eye(2), np.array([0.1, 1.0])
    found[Components] = Components(flow.uv_px, -flow.uv_px, identity, variances, 1, flow.valid, 1)
    found[Truth] = Truth(obstacle, obstacle.astype(np.float32), flow.uv_px[::4, ::4], 100_000, plane.step_px)
    return found


def around(messages: Messages, rows: int, cols: int, **more: Any) -> PictureContext:
    """Return a context that finds messages by their class."""
    return PictureContext(rows, cols, messages.get, **more)  # type: ignore[arg-type]


def drawn(pictures: Pictures, message: Message, context: PictureContext) -> Bytes:
    """Return the picture of a message that has one."""
    picture = pictures.draw(message, context)
    assert picture is not None
    return picture


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize(("rows", "cols"), [(120, 160), (480, 640), (40, 60), (61, 43), (1, 1), (300, 2), (2, 300)])
@pytest.mark.parametrize("with_colour", [True, False])
def test_a_picture_fills_its_box_in_one_direction(
    pictures: Pictures, drive: Messages, kind: type[Message], rows: int, cols: int, with_colour: bool
) -> None:
    picture = drawn(pictures, drive[kind], around(drive, rows, cols, with_colour=with_colour))
    assert picture.dtype == np.uint8
    assert picture.shape[2] == 3
    assert picture.shape[0] == rows or picture.shape[1] == cols


def test_a_message_without_a_picture_has_none(pictures: Pictures) -> None:
    assert pictures.draw(Twist(0.1, 0.2), PictureContext()) is None


@pytest.mark.parametrize("taken", [0, 1])
def test_the_component_of_the_score_is_drawn(pictures: Pictures, drive: Messages, taken: int) -> None:
    flow = drive[Flow]
    assert isinstance(flow, Flow)
    fields = [np.zeros_like(flow.uv_px), flow.uv_px] if taken else [flow.uv_px, np.zeros_like(flow.uv_px)]
    components = Components(fields[0], fields[1], np.eye(2), np.ones(2), taken, flow.valid, 1)
    context = around(drive, 120, 160)
    assert (drawn(pictures, components, context) == drawn(pictures, flow, context)).all()


def test_the_image_is_itself(pictures: Pictures, drive: Messages) -> None:
    image = drive[Image]
    assert isinstance(image, Image)
    picture = drawn(pictures, image, PictureContext(*image.pixels.shape[:2]))
    assert np.array_equal(picture, image.pixels)


def test_a_plane_lies_over_the_image_of_its_moment(pictures: Pictures, drive: Messages) -> None:
    over = drawn(pictures, drive[Plane], around(drive, 120, 160))
    alone = drawn(pictures, drive[Plane], PictureContext(120, 160))
    plane = drive[Plane]
    assert isinstance(plane, Plane)
    obstacle = plane.obstacle.repeat(plane.step_px, 0).repeat(plane.step_px, 1) != 0
    for picture in (over, alone):
        red, blue = picture[..., 0].astype(int), picture[..., 2].astype(int)
        assert (red - blue)[obstacle].mean() > 60
    image = drive[Image]
    assert isinstance(image, Image)
    ground = plane.valid.repeat(plane.step_px, 0).repeat(plane.step_px, 1) != 0
    ground &= ~obstacle
    assert np.median(np.abs(over.astype(int) - image.pixels)[ground]) == 0
    assert np.median(alone[ground]) == 235


def test_without_colour_brightness_tells(pictures: Pictures, drive: Messages) -> None:
    plane, flow = drive[Plane], drive[Flow]
    assert isinstance(plane, Plane)
    assert isinstance(flow, Flow)
    picture = drawn(pictures, plane, around(drive, *plane.obstacle.shape, with_colour=False))
    assert np.array_equal(picture[..., 0] == 255, plane.obstacle != 0)
    assert np.array_equal(picture[..., 1] == 0, plane.obstacle == 0)
    picture = drawn(pictures, flow, around(drive, *flow.valid.shape, with_colour=False))
    length_px = np.linalg.norm(flow.uv_px, axis=-1) * (flow.valid != 0)
    assert np.abs(picture[..., 0] / 255 - length_px / length_px.max()).max() < 0.01


def test_unknown_cells_are_told_from_the_rim(pictures: Pictures, drive: Messages) -> None:
    plane = drive[Plane]
    assert isinstance(plane, Plane)
    rows, cols = plane.obstacle.shape
    valid = np.ones_like(plane.valid)
    valid[:2] = 0
    half = replace(plane, obstacle=np.zeros_like(valid), valid=valid.copy())
    half.valid[: rows // 2] = 0
    rim = drawn(pictures, replace(half, valid=valid), PictureContext(4 * rows, 4 * cols))
    unknown = drawn(pictures, half, PictureContext(4 * rows, 4 * cols))
    blue, green = (unknown[: 2 * rows, :, channel].astype(int) for channel in (2, 1))
    assert (blue - green > 40).mean() == pytest.approx(0.5, abs=0.1)
    assert np.ptp(rim, axis=-1).max() == 0
    gray = drawn(pictures, half, PictureContext(rows, cols, with_colour=False))[..., 0]
    assert 0 < gray[: rows // 2].min() < 255
    assert not gray[rows // 2 :].any()


def test_an_image_of_another_view_is_not_used(pictures: Pictures, drive: Messages) -> None:
    other = Image(np.full((300, 40), 9, np.uint8))
    over = drawn(pictures, drive[Plane], around({Image: other}, 120, 160))
    assert np.array_equal(over, drawn(pictures, drive[Plane], PictureContext(120, 160)))


def test_the_map_shows_the_robot_and_its_path(pictures: Pictures, drive: Messages) -> None:
    state = drive[State]
    assert isinstance(state, State)
    bare = drawn(pictures, drive[Map], PictureContext(200, 200))
    path_m = np.array([[state.x_m - 1.0, state.y_m], [state.x_m, state.y_m]])
    plain = drawn(pictures, drive[Map], around(drive, 200, 200))
    traced = drawn(pictures, drive[Map], around(drive, 200, 200, path_m=lambda: path_m))
    assert not np.array_equal(bare, plain)
    assert not np.array_equal(plain, traced)
    assert np.array_equal(plain, drawn(pictures, state, around(drive, 200, 200)))
    assert pictures.draw(state, PictureContext()) is None


def test_a_legend_names_unknown_cells(pictures: Pictures, drive: Messages) -> None:
    plane = drive[Plane]
    assert isinstance(plane, Plane)
    unknown = replace(plane, valid=np.zeros_like(plane.valid), obstacle=np.zeros_like(plane.valid))
    bare, named = (
        drawn(pictures, unknown, PictureContext(480, 640, with_legend=with_legend)) for with_legend in (False, True)
    )
    assert not np.array_equal(bare, named)
    assert np.array_equal(bare[:400], named[:400])


def _local(state: Bytes, x_m: float, y_m: float, yaw_rad: float) -> LocalMap:
    """Return a local map of cells of 0.1 m whose first one is at (0, 0)."""
    return LocalMap(0.1, 0.0, 0.0, x_m, y_m, yaw_rad, state)


def test_a_local_map_shows_its_cells_x_to_the_right_and_y_up(pictures: Pictures) -> None:
    state = np.full((40, 60), LocalMap.UNKNOWN, np.uint8)
    state[:, 20:] = LocalMap.FREE
    state[30:, 50:] = LocalMap.OBSTACLE
    picture = drawn(pictures, _local(state, 3.0, 1.0, 0.0), PictureContext(80, 120)).astype(int)
    assert picture.shape == (80, 120, 3)
    assert picture[70, 110].tolist() == [255, 255, 255]
    red, _, blue = picture[10, 110]
    assert red - blue > 100
    assert np.ptp(picture[40, 10]) == 0
    assert 60 < picture[40, 10, 0] < 200
    gray = drawn(pictures, _local(state, 3.0, 1.0, 0.0), PictureContext(80, 120, with_colour=False))
    assert gray[10, 110, 0] > gray[70, 110, 0] > gray[40, 10, 0]


@pytest.mark.parametrize(("yaw_rad", "right", "down"), [(0.0, 1, 0), (np.pi / 2, 0, -1), (np.pi, -1, 0)])
def test_a_local_map_shows_the_robot_and_its_heading(pictures: Pictures, yaw_rad: float, right: int, down: int) -> None:
    state = np.full((40, 40), LocalMap.FREE, np.uint8)
    picture = drawn(pictures, _local(state, 1.0, 2.5, yaw_rad), PictureContext(400, 400))
    rows, cols = np.nonzero((picture != 255).any(axis=-1))
    # The mark is about the robot's place: 10.5 cells of 10 px to the right, 25.5 up; it reaches out ahead.
    ahead = np.array([cols - 104.5, rows - 144.5]).T @ [right, down]
    assert ahead.max() > 1.5 * -ahead.min()
    aside = np.array([cols - 104.5, rows - 144.5]).T @ [down, right]
    assert abs(aside.max() + aside.min()) <= 1


def test_a_robot_that_is_not_on_its_local_map_is_not_drawn(pictures: Pictures) -> None:
    state = np.full((40, 40), LocalMap.FREE, np.uint8)
    assert (drawn(pictures, _local(state, -9.0, 1.0, 0.0), PictureContext(80, 80)) == 255).all()


def test_legends_come_where_there_is_room(pictures: Pictures, drive: Messages) -> None:
    for kind in (Flow, Map):
        for size, differ in ((400, True), (100, False)):
            one, other = (
                drawn(pictures, drive[kind], around(drive, size, size, with_legend=on)) for on in (True, False)
            )
            assert np.array_equal(one, other) is not differ


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
@settings(derandomize=True, deadline=None, max_examples=60)
@given(data=st.data())
def test_damaged_messages_are_drawn_or_refused(pictures: Pictures, kind: type[Message], data: st.DataObject) -> None:
    small = _small()
    bytes_ = bytearray(encode(small[kind], 1, 2))
    for place in data.draw(st.lists(st.integers(24, len(bytes_) - 1), max_size=6)):
        bytes_[place] = data.draw(st.integers(0, 255))
    try:
        message = decode(kind, bytes(bytes_))[2]
    except DecodeError:
        return
    rows, cols = data.draw(st.integers(1, 90)), data.draw(st.integers(1, 90))
    try:
        drawn(pictures, message, around(small, rows, cols, with_colour=data.draw(st.booleans())))
    except DrawingError:
        return


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 3e38, 1e300])
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_numbers_of_any_size_are_drawn_or_refused(pictures: Pictures, kind: type[Message], value: float) -> None:
    small = _small()
    message = small[kind]
    for field in fields(message):
        old = getattr(message, field.name)
        if isinstance(old, np.ndarray) and old.dtype.kind == "f":
            with np.errstate(over="ignore"):
                new: Any = np.full_like(old, value)
        elif isinstance(old, float):
            new = value
        else:
            continue
        for with_colour in (True, False):
            with suppress(DrawingError):
                around_it = around(small, 50, 70, with_colour=with_colour)
                drawn(pictures, replace(message, **{field.name: new}), around_it)


def test_a_map_of_a_million_bodies_is_refused(pictures: Pictures) -> None:
    world = _small()[Map]
    many = replace(world, kind=np.zeros(10**6, np.uint8), height_m=np.zeros(10**6))
    with pytest.raises(DrawingError, match="1000000 bodies"):
        drawn(pictures, many, PictureContext())


def _small() -> Messages:
    """Return a small message of each kind."""
    uv, valid = np.ones((6, 8, 2), np.float32), np.ones((6, 8), np.uint8)
    square = np.array([[0, 0], [4, 0], [4, 4], [0, 4]], np.float64)
    world = Map(
        kind=np.array([0], np.uint8),
        height_m=np.ones(1),
        vertices_m=square,
        body=np.zeros(4, np.int32),
        start=np.array([2.0, 2.0, 0.0]),
        goal_m=square / 4,
        robot_radius_m=0.2,
        shortest_m=1.0,
        footprint_m=square / 8,
    )
    force = np.array([0.1, 0.9])
    states = (np.arange(48, dtype=np.uint8) % 3).reshape(6, 8)
    return {
        Image: Image(np.arange(48, dtype=np.uint8).reshape(6, 8)),
        Flow: Flow(uv, valid, 1),
        Plane: Plane(valid, uv[..., 0], valid, 1, 0.5),
        Potential: Potential(uv[..., 0], uv, 1),
        State: State(1.0, 2.0, 0.1, 0.0, 0.0, 0.5, False, False, np.zeros((1, 3))),
        Map: world,
        Steering: Steering(force, force, force, 0.1, force),
        Planar: Planar(uv, valid, uv[..., 0], 1),
        Truth: Truth(valid, uv[..., 0], uv, 1),
        LocalMap: LocalMap(0.1, -0.3, -0.2, 0.0, 0.1, 0.5, states),
        Scan: Scan(-1.0, 0.25, 0.1, 3.0, np.array([1, 2, np.inf, np.nan, 0, 4, 1, 2], np.float32)),
        Components: Components(uv, 2 * uv, np.eye(2), np.array([0.1, 1.0]), 1, valid, 1),
    }
