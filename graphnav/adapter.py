"""Adapters: messages of ours from LCM types of other packages, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from graphnav.messages import Message


class Adapter:
    """Turns an LCM type that another package defines into a message of ours, and back.

    A plugin's hook ``graphnav_adapters`` returns adapters; a graph finds them by ``type_name`` before it looks for a
    type that is installed. One direction is enough::

        class BasePose(Adapter):
            type_name = "base.pose_t"
            lcm_class = base.pose_t
            message = Odometry

            def from_lcm(self, fields: Mapping[str, Any]) -> Odometry:
                return Odometry(x_m=fields["pos"][0], ...)
    """

    type_name: ClassVar[str]
    """``package.type_t``, as graphs name it."""
    lcm_class: ClassVar[type]
    """What lcm-gen made of it; it need not be importable under ``type_name``."""
    message: ClassVar[type[Message]]

    def from_lcm(self, fields: Mapping[str, Any]) -> Message:
        """Return the message that the LCM fields hold; arrays are numpy arrays, received read-only.

        Raises
        ------
        ValueError
            The fields hold nothing that this adapter can read; the message is counted and not used.
        """
        raise NotImplementedError

    def to_lcm(self, message: Any, utime: int) -> Mapping[str, Any]:
        """Return the LCM fields for a message stamped ``utime`` (microseconds); sizes of arrays may be left out."""
        raise NotImplementedError

    def utime(self, fields: Mapping[str, Any]) -> int | None:
        """Return the sender's stamp in microseconds, None where the type has none; by default the field ``utime``."""
        value = fields.get("utime")
        return value if isinstance(value, int) else None

    @classmethod
    def reads(cls) -> bool:
        """Whether it turns their type into ours."""
        return cls.from_lcm is not Adapter.from_lcm

    @classmethod
    def writes(cls) -> bool:
        """Whether it turns ours into theirs."""
        return cls.to_lcm is not Adapter.to_lcm
