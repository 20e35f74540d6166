"""Adapters between LCM and ROS 2 types of other packages and messages of graphnav; not a family of stages."""

from __future__ import annotations

from graphnav import Adapter, hookimpl


@hookimpl
def graphnav_adapters() -> list[Adapter]:
    """Return the adapters; their modules are imported only now."""
    from graphnav_adapters.bot_core_image import BotCoreImage
    from graphnav_adapters.ros2_camera import RosCameraInfo, RosCompressedImage, RosImage
    from graphnav_adapters.ros2_motion import RosBool, RosOccupancyGrid, RosOdometry, RosTwist, RosTwistStamped

    return [
        BotCoreImage(),
        RosImage(),
        RosCompressedImage(),
        RosCameraInfo(),
        RosOdometry(),
        RosTwist(),
        RosTwistStamped(),
        RosBool(),
        RosOccupancyGrid(),
    ]
