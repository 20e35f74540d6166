"""The adapters of ROS 2 types: what they make of messages, and what they refuse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from graphnav_adapters.ros2_camera import RosCameraInfo, RosCompressedImage, RosImage
from graphnav_adapters.ros2_motion import RosBool, RosOccupancyGrid, RosOdometry, RosTwist, RosTwistStamped

from graphnav import CameraInfo, FieldError, Image, LocalMap, Odometry, Stop, Twist
from graphnav.core.catalog import Catalog

UTIME = 1_700_000_000_123_456
GRAY = np.arange(12, dtype=np.uint8).reshape(3, 4)
COLOUR = np.arange(36, dtype=np.uint8).reshape(3, 4, 3)


def there_and_back(adapter: Any, message: Any) -> tuple[Any, int | None]:
    """Return what becomes of a message on the wire, and its stamp."""
    fields = adapter.ros_type.decode(adapter.ros_type.encode(adapter.to_ros(message, UTIME)))
    return adapter.from_ros(fields), adapter.utime(fields)


def picture(**changed: Any) -> dict[str, Any]:
    """Return the fields of a gray picture."""
    return {"height": 3, "width": 4, "encoding": "mono8", "step": 4, "data": GRAY.reshape(-1)} | changed


@pytest.mark.parametrize("pixels", [GRAY, COLOUR])
def test_a_picture_comes_back_with_its_stamp(pixels: Any) -> None:
    found, utime = there_and_back(RosImage(), Image(pixels=pixels))
    np.testing.assert_array_equal(found.pixels, pixels)
    assert utime == UTIME


def test_channels_are_brought_into_order_and_padding_is_left_out() -> None:
    adapter = RosImage()
    bgr = adapter.from_ros(picture(encoding="bgr8", step=12, data=COLOUR[:, :, ::-1].reshape(-1)))
    np.testing.assert_array_equal(bgr.pixels, COLOUR)
    bgra = np.dstack([COLOUR[:, :, ::-1], GRAY])
    found = adapter.from_ros(picture(encoding="bgra8", step=16, data=bgra.reshape(-1)))
    np.testing.assert_array_equal(found.pixels, COLOUR)
    padded = np.pad(GRAY, ((0, 0), (0, 3)))
    found = adapter.from_ros(picture(step=7, data=padded.reshape(-1)))
    np.testing.assert_array_equal(found.pixels, GRAY)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"data": GRAY.reshape(-1)[:5]}, "size of data is 5, expected height * step = 3 * 4 = 12"),
        ({"step": 3}, "step is 3, expected 4 or more, the bytes of a row"),
        ({"encoding": "yuv422"}, "encoding is 'yuv422', expected mono8, 8UC1, rgb8, bgr8, rgba8, bgra8"),
        ({"height": 0}, "height is 0, expected 1 or more"),
        ({"height": 2**32 - 1}, "width * height is 4 * 4294967295, expected 64 million at most"),
    ],
)
def test_a_picture_that_contradicts_itself_is_refused(changed: dict[str, Any], told: str) -> None:
    with pytest.raises(FieldError) as caught:
        RosImage().from_ros(picture(**changed))
    assert str(caught.value) == told


def test_a_jpeg_comes_back_nearly_and_damage_is_refused() -> None:
    smooth = np.repeat(np.linspace(0, 255, 32).astype(np.uint8)[None], 24, axis=0)
    for pixels in (smooth, np.dstack([smooth] * 3)):
        found, utime = there_and_back(RosCompressedImage(), Image(pixels=pixels))
        assert np.abs(found.pixels.astype(int) - pixels).max() < 12
        assert utime == UTIME
    with pytest.raises(ValueError, match="data is not a JPEG"):
        RosCompressedImage().from_ros({"data": np.zeros(5, np.uint8)})


def test_poses_and_commands_come_back() -> None:
    pose = Odometry(x_m=1.0, y_m=-2.0, yaw_rad=3.0, v_mps=0.25, omega_radps=-0.5)
    found, utime = there_and_back(RosOdometry(), pose)
    assert (found.x_m, found.y_m, found.v_mps, found.omega_radps, utime) == (1.0, -2.0, 0.25, -0.5, UTIME)
    assert found.yaw_rad == pytest.approx(3.0)
    for adapter, stamp in ((RosTwist(), None), (RosTwistStamped(), UTIME)):
        found, utime = there_and_back(adapter, Twist(v_mps=0.5, omega_radps=-1.0))
        assert (found.v_mps, found.omega_radps, utime) == (0.5, -1.0, stamp)
    found, utime = there_and_back(RosBool(), Stop(engaged=True))
    assert (found.engaged, utime) == (True, None)


@pytest.mark.parametrize("turned", [0.0, np.nan, 3.0])
def test_an_orientation_that_is_not_one_is_refused(turned: float) -> None:
    fields = RosOdometry().to_ros(Odometry(x_m=0.0, y_m=0.0, yaw_rad=0.0, v_mps=0.0, omega_radps=0.0), UTIME)
    kind = RosOdometry().ros_type
    fields["pose"]["pose"]["orientation"]["w"] = turned
    with pytest.raises(FieldError, match=r"norm of pose\.pose\.orientation is"):
        RosOdometry().from_ros(kind.decode(kind.encode(fields)))


def test_parameters_of_a_camera_come_back() -> None:
    matrix = np.array([[114.0, 0.0, 79.5], [0.0, 114.0, 59.5], [0.0, 0.0, 1.0]])
    info = CameraInfo(120, 160, "plumb_bob", matrix, np.array([-0.2, 0.04, 0.0, 0.0, 0.0]), np.eye(3), np.eye(3, 4))
    found, utime = there_and_back(RosCameraInfo(), info)
    assert all(map(np.array_equal, vars(found).values(), vars(info).values()))
    assert utime == UTIME
    fields = {**RosCameraInfo().to_ros(info, UTIME), "k": np.zeros(9)}
    with pytest.raises(FieldError, match="focal length is 0, expected more than 0: calibrate the camera"):
        RosCameraInfo().from_ros(fields)


def test_a_map_is_told_as_ros_does() -> None:
    state = np.array([[0, 1, 2], [3, 1, 0]], np.uint8)
    local = LocalMap(
        cell_m=0.1,
        origin_x_m=1.0,
        origin_y_m=2.0,
        x_m=1.1,
        y_m=2.0,
        yaw_rad=0.0,
        state=state,
    )
    kind = RosOccupancyGrid().ros_type
    found = kind.decode(kind.encode(RosOccupancyGrid().to_ros(local, UTIME)))
    assert found["data"].tolist() == [-1, 0, 100, 100, 0, -1]
    assert (found["info"]["width"], found["info"]["height"]) == (3, 2)
    assert found["info"]["origin"]["position"] == pytest.approx({"x": 0.95, "y": 1.95, "z": 0.0})
    assert found["info"]["resolution"] == pytest.approx(0.1)


def test_the_catalog_keeps_them_apart_from_those_of_lcm() -> None:
    adapters = Catalog().adapters()
    assert {"sensor_msgs/Image", "nav_msgs/Odometry", "geometry_msgs/Twist"} <= adapters.ros_readers.keys()
    assert "nav_msgs/OccupancyGrid" in adapters.ros_writers
    assert not any("/" in name for name in (*adapters.readers, *adapters.writers))
