"""The header of ROS 2 messages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def header(utime: int, frame_id: str) -> Mapping[str, Any]:
    """Return a ``std_msgs/Header`` with a stamp in microseconds."""
    sec, us = divmod(utime, 1_000_000)
    return {"stamp": {"sec": sec, "nanosec": us * 1000}, "frame_id": frame_id}
